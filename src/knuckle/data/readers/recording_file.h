// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "knuckle/core/regular_file.h"

namespace knuckle {

/// The bytes of a recording, at any place. Safe to be read by many threads.
class RecordingFile {
 public:
  /// Throws an Error that names the file where it is missing, not regular or cannot be opened.
  explicit RecordingFile(std::filesystem::path path);

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return file_.size(); }  ///< [bytes], when it was opened

  /// Throws, before memory is taken, where the file does not hold these bytes.
  std::vector<std::uint8_t> read(std::uint64_t at, std::uint64_t count) const;
  /// The same, of no more bytes than lie before `end`, which lies in the file.
  std::vector<std::uint8_t> read_up_to(std::uint64_t at, std::uint64_t count, std::uint64_t end) const;
  /// "file: at byte 13", for messages.
  std::string place(std::uint64_t at) const;

 private:
  std::filesystem::path path_;
  RegularFile file_;
};

}  // namespace knuckle
