// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/data/readers/recording_file.h"

namespace knuckle {

/// What a record of an MCAP file is (specification of MCAP, version 0, "Opcodes"). There are others, which
/// are no matter of ours.
enum class McapRecordKind : std::uint8_t {
  header = 1,
  footer = 2,
  schema = 3,
  channel = 4,
  message = 5,
  chunk = 6,
  message_index = 7,
  statistics = 11,
  data_end = 15,
};

/// Before each record: its kind and the length of what follows.
inline constexpr std::uint64_t kMcapRecordHeadBytes = 9;

/// A record: its kind, and where its content is.
struct McapRecord {
  McapRecordKind kind;
  std::uint64_t at;          ///< of the record itself, from the beginning of the file [bytes]
  std::uint64_t data_at;     ///< of its content
  std::uint64_t data_bytes;  ///< these lie in the file
  std::uint64_t end() const { return data_at + data_bytes; }
};

/// An MCAP file as records at places, with its beginning and end checked. Safe to be read by many threads.
class McapFile : public RecordingFile {
 public:
  /// Throws an Error that names the file where it is missing, not regular, not MCAP, of another version, or
  /// was not closed by its recorder, or where the sum of its summary is wrong.
  explicit McapFile(std::filesystem::path path);

  std::uint64_t first_record() const;                    ///< where it is [bytes]
  std::uint64_t records_end() const { return footer_; }  ///< where the footer begins [bytes]

  /// The record at a place before `records_end`, before which it ends; else an Error says that the file is
  /// damaged.
  McapRecord record_at(std::uint64_t at) const;
  /// The content of a record that describes something, or the first bytes of any other, at most `most_bytes`.
  std::vector<std::uint8_t> start_of(const McapRecord& record, std::uint64_t most_bytes) const;
  /// All of the content of a record that describes something. Throws where that is longer than the limit.
  std::vector<std::uint8_t> content_of(const McapRecord& record) const;

  /// The sum of these bytes (CRC-32, as zips have it).
  std::uint32_t sum_of(std::uint64_t at, std::uint64_t end) const;

 private:
  void require_magic() const;
  void check_summary() const;

  std::uint64_t footer_ = 0;
};

}  // namespace knuckle
