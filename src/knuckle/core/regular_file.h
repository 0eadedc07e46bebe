// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace knuckle {

/// Throws an Error that names `path` where it is missing or not a regular file: a folder, or a FIFO, device
/// or socket, which would never end. For what a library opens by its name.
void require_regular_file(const std::filesystem::path& path);

/// A regular file that is open for reading, and closed in the end.
class RegularFile {
 public:
  /// Throws as `require_regular_file` does, and where the file cannot be opened.
  explicit RegularFile(const std::filesystem::path& path);
  RegularFile(const RegularFile&) = delete;
  RegularFile& operator=(const RegularFile&) = delete;
  ~RegularFile();
  int descriptor() const { return descriptor_; }
  std::uint64_t size() const { return size_; }  ///< [bytes], when it was opened

 private:
  int descriptor_;
  std::uint64_t size_ = 0;
};

/// All bytes of a regular file. Throws an Error that names it where it cannot be read, is not a regular file,
/// or has more than `most_bytes`; before memory is taken.
std::string read_regular_file(const std::filesystem::path& path, std::int64_t most_bytes);

}  // namespace knuckle
