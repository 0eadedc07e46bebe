// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/file_stream.h"

#include <algorithm>
#include <array>

#include <zlib.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 16;

}  // namespace

class FileStream::Inflater {
 public:
  Inflater() {
    if (inflateInit(&stream_) != Z_OK) throw std::bad_alloc();
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() { inflateEnd(&stream_); }

  /// Takes from the front of `from` what it needs; returns how many bytes it gave.
  std::size_t step(std::span<const std::uint8_t>& from, std::span<std::uint8_t> to) {
    const auto room = static_cast<unsigned>(std::min(to.size(), kBlockBytes));
    stream_.next_in = const_cast<std::uint8_t*>(from.data());  // zlib does not write there
    stream_.avail_in = static_cast<unsigned>(from.size());
    stream_.next_out = to.data();
    stream_.avail_out = room;
    const int status = inflate(&stream_, Z_NO_FLUSH);
    from = from.subspan(from.size() - stream_.avail_in);
    is_end_ = status == Z_STREAM_END;
    is_damaged_ = status != Z_OK && status != Z_STREAM_END && status != Z_BUF_ERROR;
    return room - stream_.avail_out;
  }
  bool is_end() const { return is_end_; }
  bool is_damaged() const { return is_damaged_; }

 private:
  z_stream stream_{};
  bool is_end_ = false;
  bool is_damaged_ = false;
};

FileStream::FileStream(const RecordingFile& file, std::uint64_t at, std::uint64_t count, Packing packing)
    : file_(&file),
      start_(at),
      at_(at),
      end_(at + count),
      inflater_(packing == Packing::zlib ? std::make_unique<Inflater>() : nullptr) {}

FileStream::~FileStream() = default;
FileStream::FileStream(FileStream&&) noexcept = default;
FileStream& FileStream::operator=(FileStream&&) noexcept = default;

std::string FileStream::place() const {
  return file_->place(start_);
}

void FileStream::refill() {
  if (!left_.empty() || at_ == end_) return;
  block_ = file_->read(at_, std::min<std::uint64_t>(kBlockBytes, end_ - at_));
  at_ += block_.size();
  left_ = block_;
}

bool FileStream::is_drained() const {
  return (inflater_ && inflater_->is_end()) || (left_.empty() && at_ == end_);
}

/// Some of the next bytes; none at the end.
std::size_t FileStream::give(std::span<std::uint8_t> bytes) {
  refill();
  if (inflater_) {
    if (inflater_->is_end()) return 0;
    const std::size_t given = inflater_->step(left_, bytes);
    if (inflater_->is_damaged()) fail("{}: its packed bytes are damaged", place());
    return given;
  }
  const std::size_t given = std::min(left_.size(), bytes.size());
  std::copy_n(left_.begin(), given, bytes.begin());
  left_ = left_.subspan(given);
  return given;
}

void FileStream::read(std::span<std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const bool was_drained = is_drained();
    const std::size_t given = give(bytes);
    if (given == 0 && was_drained) fail("{}: is cut short or damaged", place());
    bytes = bytes.subspan(given);
    taken_ += given;
  }
}

void FileStream::skip(std::uint64_t count) {
  std::array<std::uint8_t, 4096> dropped{};
  while (count > 0) {
    const auto some = static_cast<std::size_t>(std::min<std::uint64_t>(count, dropped.size()));
    read(std::span(dropped).first(some));
    count -= some;
  }
}

void FileStream::require_end() {
  std::uint8_t beyond = 0;
  while (inflater_ && !inflater_->is_end()) {
    const bool was_drained = is_drained();
    if (give(std::span(&beyond, 1)) > 0) fail("{}: holds more than it says", place());
    if (was_drained && !inflater_->is_end()) fail("{}: is cut short or damaged", place());
  }
  if (!left_.empty() || at_ != end_) fail("{}: holds more than it says", place());
}

}  // namespace knuckle
