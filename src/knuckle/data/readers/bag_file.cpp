// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/bag_file.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/byte_cursor.h"

namespace knuckle {
namespace {

constexpr std::string_view kBagSignature = "#ROSBAG V";
constexpr std::string_view kBagVersion = "2.0\n";

}  // namespace

BagFields::BagFields(std::span<const std::uint8_t> bytes, std::string where) : where_(std::move(where)) {
  ByteCursor cursor(bytes, where_);
  while (cursor.left() > 0) {
    const std::string_view field = cursor.text(cursor.u32());
    const std::size_t equals = field.find('=');
    if (equals == std::string_view::npos) fail("{}: the bag is damaged: a field has no '='", where_);
    fields_.emplace_back(field.substr(0, equals), field.substr(equals + 1));
  }
}

std::string_view BagFields::text(std::string_view name) const {
  const auto field = std::ranges::find(fields_, name, &std::pair<std::string, std::string>::first);
  return field == fields_.end() ? std::string_view() : std::string_view(field->second);
}

std::string_view BagFields::bytes_of(std::string_view name, std::size_t count) const {
  const std::string_view value = text(name);
  if (value.size() != count) {
    fail("{}: the bag is damaged: the field '{}' has {} bytes, expected {}", where_, name, value.size(),
         count);
  }
  return value;
}

BagRecordKind BagFields::kind() const {
  return static_cast<BagRecordKind>(bytes_of("op", 1).front());
}

std::uint64_t BagFields::u64(std::string_view name) const {
  const std::string_view value = bytes_of(name, 8);
  return ByteCursor({reinterpret_cast<const std::uint8_t*>(value.data()), value.size()}, where_).u64();
}

std::uint32_t BagFields::u32(std::string_view name) const {
  const std::string_view value = bytes_of(name, 4);
  return ByteCursor({reinterpret_cast<const std::uint8_t*>(value.data()), value.size()}, where_).u32();
}

BagFile::BagFile(std::filesystem::path file) : RecordingFile(std::move(file)) {
  const std::vector<std::uint8_t> start = read(0, std::min<std::uint64_t>(size(), first_record()));
  const std::string_view line(reinterpret_cast<const char*>(start.data()), start.size());
  if (!line.starts_with(kBagSignature)) fail("{}: is not a ROS 1 bag (#ROSBAG V2.0)", path().string());
  const std::string_view version = line.substr(kBagSignature.size());
  if (version != kBagVersion) {
    fail("{}: is a ROS bag of version '{}', expected 2.0", path().string(), printable(trimmed(version)));
  }
}

std::uint64_t BagFile::first_record() const {
  return kBagSignature.size() + kBagVersion.size();
}

BagRecord BagFile::record_at(std::uint64_t at, std::uint64_t end) const {
  const auto require_bytes = [&](std::uint64_t from, std::uint64_t count) {
    if (from > end || count > end - from) {
      fail("{}: the bag is cut short or damaged: a record ends after byte {}", place(at), end);
    }
  };
  const auto length_at = [&](std::uint64_t from) {
    require_bytes(from, 4);
    const std::vector<std::uint8_t> bytes = read(from, 4);
    return std::uint64_t{ByteCursor(bytes, "").u32()};
  };
  const std::uint64_t header_bytes = length_at(at);
  require_bytes(at + 4, header_bytes);
  if (header_bytes > static_cast<std::uint64_t>(limits::kRecordHeaderBytes)) {
    fail("{}: the header of a record has {} bytes, expected at most {}", place(at), header_bytes,
         limits::kRecordHeaderBytes);
  }
  const std::uint64_t data_bytes = length_at(at + 4 + header_bytes);
  const std::uint64_t data_at = at + 8 + header_bytes;
  require_bytes(data_at, data_bytes);
  return {BagFields(read(at + 4, header_bytes), place(at)), data_at, data_bytes};
}

}  // namespace knuckle
