// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

struct zip;

namespace knuckle {

/// Reads the records of a zip whose bytes lie in it as they are, as LibTorch writes them. Faults are Errors
/// of one line that name the file.
class ZipReader {
 public:
  /// A file in the zip.
  struct Record {
    std::string name;
    std::uint64_t index;
    std::uint64_t bytes;
  };

  /// Throws an Error where there is no such file. One that is not a zip, or is cut short, has no records.
  explicit ZipReader(const std::filesystem::path& path);
  ~ZipReader();
  ZipReader(const ZipReader&) = delete;
  ZipReader& operator=(const ZipReader&) = delete;

  /// Those that are not compressed.
  const std::vector<Record>& records() const { return records_; }
  /// The record's first bytes, at most all of it.
  std::string read_start(const Record& record, std::size_t most) const;
  /// Reads the whole record, whose size `to` has, and checks its sum.
  void read(const Record& record, std::span<std::byte> to) const;

 private:
  struct Close {
    void operator()(zip* archive) const;
  };

  std::string path_;
  std::unique_ptr<zip, Close> archive_;
  std::vector<Record> records_;
};

}  // namespace knuckle
