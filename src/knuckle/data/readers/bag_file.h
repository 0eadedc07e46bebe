// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/data/readers/recording_file.h"

namespace knuckle {

/// What a record of a bag is (Bag Format 2.0, "Op codes").
enum class BagRecordKind : std::uint8_t {
  message = 2,
  bag_header = 3,
  index_data = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7,
};

/// The `name=value` fields of a record's header, or of a connection's data.
class BagFields {
 public:
  /// Throws an Error that starts with `where` where the bytes are not fields.
  BagFields(std::span<const std::uint8_t> bytes, std::string where);

  BagRecordKind kind() const;
  std::uint32_t u32(std::string_view name) const;
  std::uint64_t u64(std::string_view name) const;
  /// Empty where there is no such field.
  std::string_view text(std::string_view name) const;

 private:
  std::string_view bytes_of(std::string_view name, std::size_t count) const;

  std::vector<std::pair<std::string, std::string>> fields_;
  std::string where_;
};

/// A record: its header, and where its data are.
struct BagRecord {
  BagFields fields;
  std::uint64_t data_at;     ///< from the beginning of the file [bytes]
  std::uint64_t data_bytes;  ///< these lie in the file
  std::uint64_t end() const { return data_at + data_bytes; }
};

/// A ROS 1 bag of format 2.0 as records at places. Safe to be read by many threads.
class BagFile : public RecordingFile {
 public:
  /// Throws an Error that names the file where it is missing, not regular, or not a bag of this version.
  explicit BagFile(std::filesystem::path path);

  std::uint64_t first_record() const;  ///< where it is [bytes]

  /// The record at a place; it ends before `end`, or an Error says that the file is damaged or cut short.
  BagRecord record_at(std::uint64_t at, std::uint64_t end) const;
  BagRecord record_at(std::uint64_t at) const { return record_at(at, size()); }
};

}  // namespace knuckle
