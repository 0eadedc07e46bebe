// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "knuckle/core/regular_file.h"

namespace knuckle {

/// An open HDF5 file as bytes at addresses. They are read where they are asked for and never mapped: a file
/// that shrinks meanwhile is a fault, not a signal. Safe to be read by many threads.
class Hdf5Bytes {
 public:
  /// Reads the superblock, of version 0 to 3 (File Format Specification, II.A). Throws an Error that names
  /// the file where it is missing, not regular, no HDF5, or cut short.
  explicit Hdf5Bytes(std::filesystem::path path);
  Hdf5Bytes(const Hdf5Bytes&) = delete;
  Hdf5Bytes& operator=(const Hdf5Bytes&) = delete;

  const std::filesystem::path& path() const { return path_; }
  std::uint64_t size() const { return file_.size(); }           ///< when it was opened
  std::uint64_t root() const { return root_; }                  ///< address of the root's object header
  std::size_t address_bytes() const { return address_bytes_; }  ///< of an address in the file
  std::size_t length_bytes() const { return length_bytes_; }    ///< of a length

  /// The bytes from `address` on. Throws, before memory is taken, where the file does not hold them.
  std::vector<std::uint8_t> read(std::uint64_t address, std::uint64_t count) const;
  /// The same, fewer where the file ends.
  std::vector<std::uint8_t> read_at_most(std::uint64_t address, std::uint64_t count) const;
  void read_to(std::uint64_t address, std::span<std::uint8_t> to) const;

  [[noreturn]] void damaged(std::string_view why) const;
  /// For what newer versions of the library may write, but not by default.
  [[noreturn]] void too_new(std::string_view what) const;

 private:
  void read_superblock();

  std::filesystem::path path_;
  RegularFile file_;
  std::uint64_t base_ = 0;  ///< where address 0 is
  std::uint64_t root_ = 0;
  std::size_t address_bytes_ = 8;
  std::size_t length_bytes_ = 8;
};

/// Reads little-endian numbers from the front of bytes, which outlive it; throws where they end too early.
class Hdf5Cursor {
 public:
  Hdf5Cursor(std::span<const std::uint8_t> bytes, const Hdf5Bytes& file) : bytes_(bytes), file_(&file) {}

  std::uint64_t number(std::size_t bytes);
  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
  std::uint64_t length() { return number(file_->length_bytes()); }
  /// Nothing where the file says that there is none.
  std::optional<std::uint64_t> address();
  /// The same where one must be.
  std::uint64_t defined_address();
  std::span<const std::uint8_t> take(std::uint64_t count);
  void skip(std::uint64_t count) { take(count); }
  void expect_signature(std::string_view signature);
  std::size_t left() const { return bytes_.size(); }
  const Hdf5Bytes& file() const { return *file_; }

 private:
  std::span<const std::uint8_t> bytes_;
  const Hdf5Bytes* file_;
};

}  // namespace knuckle
