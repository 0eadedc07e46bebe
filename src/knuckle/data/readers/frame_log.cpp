// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/frame_log.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/storage/deflate.h"
#include "knuckle/storage/open_own_file.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::string_view kMagic = "knuckle frame log 3\n";

/// What stands before a record's content, and its checksum after it, which covers both.
struct RecordHead {
  std::int64_t index;
  std::uint64_t size;  ///< of the content [bytes]
};
using Checksum = std::uint32_t;

std::string system_message(int code) {
  return std::generic_category().message(code);
}

std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::vector<std::uint8_t> record_of(std::int64_t index, std::span<const std::uint8_t> content) {
  const RecordHead head{index, content.size()};
  std::vector<std::uint8_t> bytes(sizeof(head) + content.size() + sizeof(Checksum));
  std::memcpy(bytes.data(), &head, sizeof(head));
  std::ranges::copy(content, bytes.begin() + sizeof(head));
  const Checksum sum = adler32(std::span(bytes).first(bytes.size() - sizeof(Checksum)));
  std::memcpy(bytes.data() + bytes.size() - sizeof(sum), &sum, sizeof(sum));
  return bytes;
}

}  // namespace

bool is_frame_log(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return false;
  std::string start(kMagic.size(), '\0');
  std::ifstream(path, std::ios::binary).read(start.data(), static_cast<std::streamsize>(start.size()));
  return start == kMagic;
}

FrameLog::FrameLog(fs::path path, std::string_view identity)
    : path_(std::move(path)), descriptor_(open_own_file_alone(path_, O_CREAT, "another run is writing it")) {
  const std::string head = fmt::format("{}{}\n{}\n", kMagic, identity.size(), identity);
  try {
    restore(head);
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

FrameLog::~FrameLog() {
  ::close(descriptor_);
}

void FrameLog::restore(const std::string& head) {
  const std::uint64_t file_size = fs::file_size(path_);
  std::string found(std::min<std::uint64_t>(head.size(), file_size), '\0');
  const bool is_read = read_at(0, {reinterpret_cast<std::uint8_t*>(found.data()), found.size()}) &&
                       found.size() >= kMagic.size();
  if (is_read && found.starts_with(kMagic) && !head.starts_with(found)) {
    fail(
        "{}: is left from a run with another manifest or other frames, or of another version of the program; "
        "end it with what began it, or remove the file",
        path_.string());
  }
  if (is_read && found == head) {
    end_ = head.size();
    while (restore_record(file_size)) {
    }
  }
  if (::ftruncate(descriptor_, static_cast<off_t>(end_)) != 0)
    fail("{}: cannot write: {}", path_.string(), system_message(errno));
  if (end_ > 0) return;
  write_at(0, as_bytes(head));
  end_ = head.size();
}

/// Takes the record at `end_` into account; false where there is no whole one.
bool FrameLog::restore_record(std::uint64_t file_size) {
  RecordHead head{};
  if (file_size - end_ < sizeof(head) + sizeof(Checksum)) return false;
  if (!read_at(end_, {reinterpret_cast<std::uint8_t*>(&head), sizeof(head)})) return false;
  if (head.size > file_size - end_ - sizeof(head) - sizeof(Checksum)) return false;
  std::vector<std::uint8_t> content(head.size);
  Checksum sum = 0;
  const std::uint64_t start = end_ + sizeof(head);
  if (!read_at(start, content)) return false;
  if (!read_at(start + head.size, {reinterpret_cast<std::uint8_t*>(&sum), sizeof(sum)})) return false;
  std::vector<std::uint8_t> expected = record_of(head.index, content);
  Checksum expected_sum = 0;
  std::memcpy(&expected_sum, expected.data() + expected.size() - sizeof(sum), sizeof(sum));
  if (!is_sum(sum, expected_sum)) return false;
  note({head.index, start, head.size});
  end_ += expected.size();
  return true;
}

void FrameLog::note(const Record& record) {
  is_sorted_ = is_sorted_ && (records_.empty() || records_.back().index < record.index);
  records_.push_back(record);
}

/// By index; of several records of a frame the last one counts.
void FrameLog::sort_records() const {
  if (std::exchange(is_sorted_, true)) return;
  std::ranges::stable_sort(records_, {}, &Record::index);
  const auto is_replaced = [](const Record& record, const Record& next) {
    return record.index == next.index;
  };
  std::ranges::reverse(records_);
  records_.erase(std::unique(records_.begin(), records_.end(), is_replaced), records_.end());
  std::ranges::reverse(records_);
}

std::vector<std::int64_t> FrameLog::indices() const {
  const std::lock_guard lock(mutex_);
  sort_records();
  std::vector<std::int64_t> indices;
  for (const Record& record : records_) indices.push_back(record.index);
  return indices;
}

void FrameLog::append(std::int64_t index, std::span<const std::uint8_t> content) {
  const std::vector<std::uint8_t> bytes = record_of(index, content);
  const std::lock_guard lock(mutex_);
  write_at(end_, bytes);
  note({index, end_ + sizeof(RecordHead), content.size()});
  end_ += bytes.size();
}

FrameLog::Record FrameLog::record_of_frame(std::int64_t index) const {
  const std::lock_guard lock(mutex_);
  sort_records();
  const auto record = std::ranges::lower_bound(records_, index, {}, &Record::index);
  if (record == records_.end() || record->index != index)
    fail("{}: frame {} is not in it", path_.string(), index);
  return *record;
}

std::vector<std::uint8_t> FrameLog::read(std::int64_t index) const {
  const Record record = record_of_frame(index);
  std::vector<std::uint8_t> content(record.size);
  if (!read_at(record.offset, content)) fail("{}: frame {} cannot be read back", path_.string(), index);
  return content;
}

void FrameLog::remove() {
  std::error_code fault;
  fs::remove(path_, fault);
  if (fault) fail("{}: cannot be removed: {}", path_.string(), fault.message());
}

void FrameLog::write_at(std::uint64_t offset, std::span<const std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("{}: cannot write: {}", path_.string(), system_message(errno));
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

bool FrameLog::read_at(std::uint64_t offset, std::span<std::uint8_t> bytes) const {
  while (!bytes.empty()) {
    const ssize_t count = ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    offset += static_cast<std::uint64_t>(count);
    bytes = bytes.subspan(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace knuckle
