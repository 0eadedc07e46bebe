// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// Whether the file is a FrameLog's: the frames of a run that has not ended.
bool is_frame_log(const std::filesystem::path& path);

/// The frames of a file in the making, in the order in which they came: first whose they are, then a record
/// with a checksum for each. Nothing that was written is ever changed, so a kill at any moment costs at most
/// the records that were being written; a later run recognises these and drops them.
class FrameLog {
 public:
  /// Opens the log of the run that `identity` describes, or begins it. What is damaged is dropped, with all
  /// that follows. Throws an Error that names the file where it cannot be written, is in use by another
  /// process, or is left from another run.
  FrameLog(std::filesystem::path path, std::string_view identity);
  ~FrameLog();
  FrameLog(const FrameLog&) = delete;
  FrameLog& operator=(const FrameLog&) = delete;

  /// The frames in the log, in their order.
  std::vector<std::int64_t> indices() const;
  /// Adds a frame. Safe to call from many threads.
  void append(std::int64_t index, std::span<const std::uint8_t> content);
  /// The content of a frame that is in the log. Safe to call from many threads, which read at the same time.
  std::vector<std::uint8_t> read(std::int64_t index) const;
  /// Takes the file away: its frames have a place elsewhere now.
  void remove();

 private:
  struct Record {
    std::int64_t index;
    std::uint64_t offset;  ///< of the content
    std::uint64_t size;
  };

  void note(const Record& record);
  void sort_records() const;
  Record record_of_frame(std::int64_t index) const;
  void restore(const std::string& head);
  void write_at(std::uint64_t offset, std::span<const std::uint8_t> bytes) const;
  bool read_at(std::uint64_t offset, std::span<std::uint8_t> bytes) const;
  bool restore_record(std::uint64_t file_size);

  std::filesystem::path path_;
  int descriptor_;
  mutable std::mutex mutex_;  ///< guards what follows
  std::uint64_t end_ = 0;     ///< where the next record goes
  /// 24 bytes a frame, however long a recording; in no order until one is looked for.
  mutable std::deque<Record> records_;
  mutable bool is_sorted_ = true;
};

}  // namespace knuckle
