// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/matlab_array.h"

#include <algorithm>
#include <array>
#include <bit>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/data/readers/byte_cursor.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kHeaderBytes = 128;
constexpr std::uint64_t kTagBytes = 8;
constexpr std::uint64_t kAlignment = 8;  ///< of elements within an array
constexpr std::uint32_t kInt8 = 1;
constexpr std::uint32_t kInt32 = 5;
constexpr std::uint32_t kUint32 = 6;
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kCompressed = 15;
constexpr std::uint32_t kDoubleClass = 6;
constexpr std::uint32_t kLastArrayClass = 15;  ///< functions and objects of classes have other heads
constexpr std::uint32_t kComplexFlag = 0x800;
constexpr std::uint64_t kMostAxes = 32;
constexpr std::uint64_t kDeflateLimit = 1032;  ///< how much shorter deflate makes anything at most

/// Bytes of a value of a type of numbers; 0 for other types.
std::size_t bytes_of_type(std::uint32_t type) {
  constexpr std::array<std::uint8_t, 14> kBytes{0, 1, 1, 2, 2, 4, 4, 4, 0, 8, 0, 0, 8, 8};
  return type < kBytes.size() ? kBytes[type] : 0;
}

double next_value(ByteCursor& bytes, std::uint32_t type) {
  switch (type) {
    case 1:
      return static_cast<std::int8_t>(bytes.u8());
    case 2:
      return bytes.u8();
    case 3:
      return static_cast<std::int16_t>(bytes.u16());
    case 4:
      return bytes.u16();
    case 5:
      return static_cast<std::int32_t>(bytes.u32());
    case 6:
      return bytes.u32();
    case 7:
      return bytes.f32();
    case 9:
      return bytes.f64();
    case 12:
      return static_cast<double>(static_cast<std::int64_t>(bytes.u64()));
    default:
      return static_cast<double>(bytes.u64());
  }
}

/// A number of values; at most `most` + 1.
std::uint64_t count_of(const std::vector<std::int64_t>& shape, std::uint64_t most) {
  std::uint64_t count = 1;
  for (const std::int64_t length : shape) {
    if (length == 0) return 0;
    const auto factor = static_cast<std::uint64_t>(length);
    count = count > most / factor ? most + 1 : count * factor;
  }
  return count;
}

}  // namespace

/// What stands before an element's bytes within an array.
struct MatlabArray::Tag {
  std::uint32_t type = 0;
  std::uint32_t bytes = 0;
  std::uint64_t padding = 0;  ///< bytes that follow the element's, up to the next one
};

MatlabArray::MatlabArray(const std::filesystem::path& path, std::string_view name)
    : file_(path), stream_(file_, 0, 0, FileStream::Packing::none) {
  require_version_5();
  find(name);
}

void MatlabArray::require_version_5() const {
  constexpr std::uint64_t kVersionPlace = 124;
  static constexpr std::array<std::uint8_t, 4> kVersion5{0x00, 0x01, 'I', 'M'};  // 0x0100, little-endian
  if (file_.size() < kHeaderBytes || !std::ranges::equal(file_.read(kVersionPlace, 4), kVersion5)) {
    fail("{}: expected a little-endian Matlab file of version 5 (save it with -v7 or -v6)",
         file_.path().string());
  }
}

void MatlabArray::find(std::string_view name) {
  bool is_found = false;
  for (std::uint64_t place = kHeaderBytes; place < file_.size();) {
    const std::vector<std::uint8_t> tag =
        file_.read(place, std::min<std::uint64_t>(kTagBytes, file_.size() - place));
    const std::string where = file_.place(place);
    ByteCursor cursor(tag, where);
    const std::uint32_t type = cursor.u32();
    const std::uint32_t bytes = cursor.u32();
    place += kTagBytes;
    if (bytes > file_.size() - place) fail("{}: is cut short or damaged", file_.path().string());
    if (!is_found && (type == kMatrix || type == kCompressed)) {
      const bool is_packed = type == kCompressed;
      stream_ =
          FileStream(file_, place, bytes, is_packed ? FileStream::Packing::zlib : FileStream::Packing::none);
      const Tag matrix = is_packed ? read_tag() : Tag{type, bytes, 0};
      if (matrix.type != kMatrix) fail("{}: is damaged: holds no array", where);
      element_end_ = stream_.taken() + matrix.bytes;
      is_found = read_head(name);
      if (is_found) find_values(name, is_packed ? kDeflateLimit * bytes : bytes);
    }
    place += bytes;
  }
  if (!is_found) fail("{}: has no array '{}', or is cut short", file_.path().string(), name);
}

MatlabArray::Tag MatlabArray::read_tag() {
  std::array<std::uint8_t, 4> word{};
  stream_.read(word);
  const std::uint32_t first = ByteCursor(word, "").u32();
  constexpr unsigned kSmallShift = 16;  // a small element has its length in the upper half
  if (const std::uint32_t bytes = first >> kSmallShift; bytes > 0) {
    if (bytes > word.size()) fail("{}: is damaged: a small element of {} bytes", stream_.place(), bytes);
    return {first & 0xffff, bytes, word.size() - bytes};
  }
  stream_.read(word);
  const std::uint32_t bytes = ByteCursor(word, "").u32();
  return {first, bytes, (kAlignment - bytes % kAlignment) % kAlignment};
}

bool MatlabArray::read_head(std::string_view name) {
  const auto element = [&](std::uint32_t type, std::uint64_t most) {
    const Tag tag = read_tag();
    if (tag.type != type || tag.bytes > most) fail("{}: is damaged: no head of an array", stream_.place());
    std::vector<std::uint8_t> bytes(tag.bytes);
    stream_.read(bytes);
    stream_.skip(tag.padding);
    return bytes;
  };
  const std::string where = stream_.place();
  flags_ = ByteCursor(element(kUint32, kAlignment), where).u32();
  if ((flags_ & 0xff) > kLastArrayClass) return false;
  const std::vector<std::uint8_t> lengths = element(kInt32, kMostAxes * sizeof(std::int32_t));
  shape_.clear();
  for (ByteCursor cursor(lengths, where); cursor.left() > 0;) {
    const auto length = static_cast<std::int32_t>(cursor.u32());
    if (length < 0) fail("{}: is damaged: an array of length {}", where, length);
    shape_.push_back(length);
  }
  const std::vector<std::uint8_t> stored = element(kInt8, limits::kNameLength);
  return std::ranges::equal(stored, name, {}, {}, [](char c) { return static_cast<std::uint8_t>(c); });
}

void MatlabArray::find_values(std::string_view name, std::uint64_t most_bytes) {
  const std::string path = file_.path().string();
  if ((flags_ & 0xff) != kDoubleClass || (flags_ & kComplexFlag) != 0) {
    fail("{}: '{}' is not an array of doubles", path, name);
  }
  const Tag tag = read_tag();
  const std::size_t value_bytes = bytes_of_type(tag.type);
  if (value_bytes == 0) fail("{}: '{}' is damaged: its values are of type {}", path, name, tag.type);
  left_ = count_of(shape_, most_bytes);
  if (left_ > most_bytes / value_bytes) {
    fail("{}: '{}' says that it has more values than the file can hold; it is damaged", path, name);
  }
  if (left_ * value_bytes != tag.bytes) {
    fail("{}: '{}' is damaged: {} values in {} bytes", path, name, left_, tag.bytes);
  }
  type_ = tag.type;
}

void MatlabArray::read(std::span<double> values) {
  constexpr std::size_t kPiece = 4096;
  if (values.size() > left_)
    fail("{}: has {} values left, asked for {}", stream_.place(), left_, values.size());
  const std::size_t value_bytes = bytes_of_type(type_);
  std::vector<std::uint8_t> bytes;
  while (!values.empty()) {
    const std::size_t count = std::min(values.size(), kPiece);
    bytes.resize(count * value_bytes);
    stream_.read(bytes);
    ByteCursor cursor(bytes, "");
    for (double& value : values.first(count)) value = next_value(cursor, type_);
    values = values.subspan(count);
    left_ -= count;
  }
}

void MatlabArray::require_end() {
  if (left_ > 0) fail("{}: {} of its values were not read", stream_.place(), left_);
  if (stream_.taken() > element_end_) fail("{}: is damaged: holds more than it says", stream_.place());
  stream_.skip(element_end_ - stream_.taken());
  stream_.require_end();
}

}  // namespace knuckle
