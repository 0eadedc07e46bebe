// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace knuckle {

/// Where the lines of a text file start, so that any one can be read without the file in memory: 12 bytes
/// per line. Blank lines do not count, nor do lines that start with '#'. Safe to read from many threads.
class LineIndex {
 public:
  /// Scans the file once. Throws an Error that names it where it cannot be read.
  explicit LineIndex(std::filesystem::path path);

  std::int64_t size() const { return static_cast<std::int64_t>(starts_.size()); }
  const std::filesystem::path& path() const { return path_; }

  /// Line `index` in [0, size) without its end.
  std::string line(std::int64_t index) const;
  /// "file:12", the line in the file counted from 1, for messages about its content; "file" where it has no
  /// such line.
  std::string where(std::int64_t index) const;

 private:
  std::filesystem::path path_;
  std::vector<std::uint64_t> starts_;
  std::vector<std::uint32_t> numbers_;  ///< of the lines in the file, from 1
};

}  // namespace knuckle
