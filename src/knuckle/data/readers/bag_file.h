// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/core/regular_file.h"

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
class BagFile {
 public:
  /// Throws an Error that names the file where it is missing, not regular, or not a bag of this version.
  explicit BagFile(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return file_.size(); }  ///< [bytes], when it was opened
  std::uint64_t first_record() const;                  ///< where it is [bytes]

  /// The record at a place; it ends before `end`, or an Error says that the file is damaged or cut short.
  BagRecord record_at(std::uint64_t at, std::uint64_t end) const;
  BagRecord record_at(std::uint64_t at) const { return record_at(at, size()); }
  /// Throws, before memory is taken, where the file does not hold these bytes.
  std::vector<std::uint8_t> read(std::uint64_t at, std::uint64_t count) const;
  /// "file: at byte 13", for messages.
  std::string place(std::uint64_t at) const;

 private:
  std::filesystem::path path_;
  RegularFile file_;
};

}  // namespace knuckle
