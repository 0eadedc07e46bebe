// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// A numeric array of an HDF5 file in memory: its shape (slowest dimension first) and its values, row-major.
template <class T>
struct Hdf5Array {
  std::vector<std::uint64_t> shape;
  std::vector<T> values;
};

/// An HDF5 file that is read: named arrays of numbers in its root, and the root's attributes. T is one of
/// float, double, std::int8_t, std::uint8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
/// std::int64_t, std::uint64_t. Reading converts from the file's type and throws where T cannot hold a value.
///
/// This is a reader of our own, because libhdf5 crashes on damaged files. It reads what the library writes by
/// default and in its format of 1.8: superblocks of version 0 to 3, arrays in one piece, in the header, or in
/// chunks that shuffle and deflate made. What leads out of the file (links, external storage, virtual
/// arrays), other filters, texts of variable length and the newer layouts are refused by name. Safe to be
/// used by many threads at once.
class Hdf5File {
 public:
  /// Throws an Error that names the file where it is missing, cut short, or no HDF5.
  static Hdf5File open(const std::filesystem::path& path);

  Hdf5File(Hdf5File&&) noexcept;
  Hdf5File& operator=(Hdf5File&&) noexcept;
  ~Hdf5File();

  const std::filesystem::path& path() const;
  bool has(std::string_view dataset) const;
  /// Throws where the shape is more than a file of this size can hold: then the file is damaged.
  std::vector<std::uint64_t> shape(std::string_view dataset) const;

  /// Throws as `shape` does, before memory is taken.
  template <class T>
  Hdf5Array<T> read(std::string_view dataset) const;
  /// `count` entries from `first` on along the slowest dimension. `values` has room for all of them.
  template <class T>
  void read_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count, T* values) const;

  /// Attributes of the root.
  bool has_attribute(std::string_view name) const;
  /// A text of fixed length; one that is too long for an attribute is an array of bytes of that name.
  std::string text_attribute(std::string_view name) const;
  double number_attribute(std::string_view name) const;
  std::vector<double> numbers_attribute(std::string_view name) const;

  /// Throws unless the attributes `format` and `version` say `format` and a version in [1, newest_version];
  /// returns the version.
  int require_format(std::string_view format, int newest_version) const;

 private:
  struct Content;
  explicit Hdf5File(std::unique_ptr<Content> content);
  std::unique_ptr<Content> content_;
};

}  // namespace knuckle
