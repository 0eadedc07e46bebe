// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
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

/// A thin owner of an HDF5 file: named arrays and attributes, with Knuckle's errors. T is one of float,
/// double, std::int8_t, std::uint8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, std::int64_t,
/// std::uint64_t. Reading converts from the file's type. HDF5 itself is not made for threads: all calls of
/// all files take turns; chunks are inflated outside of them. Links, external storage, virtual arrays, other
/// filters than shuffle and deflate, and texts of variable length are refused: they lead out of the file, run
/// foreign code, or crash the library where the file is damaged.
class Hdf5File {
 public:
  /// Throws an Error that names the file where it is missing, cut short, or no HDF5.
  static Hdf5File open(const std::filesystem::path& path);
  static Hdf5File open_for_writing(const std::filesystem::path& path);  ///< an existing file, to add to it
  static Hdf5File create(const std::filesystem::path& path);            ///< replaces a file of that name

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

  /// How an array is stored: in one piece, or in chunks of `rows_per_chunk` rows, compressed.
  struct Storage {
    std::uint64_t rows_per_chunk = 0;  ///< 0: in one piece, not compressed
    int deflate_level = 0;             ///< 0 (none) to 9, with shuffle
  };
  template <class T>
  void write(std::string_view dataset, const std::vector<std::uint64_t>& shape, const T* values,
             const Storage& storage = {0, 0});
  /// Makes an array whose values are written later; unwritten ones are 0.
  template <class T>
  void create_dataset(std::string_view dataset, const std::vector<std::uint64_t>& shape,
                      const Storage& storage);
  template <class T>
  void write_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count, const T* values);

  /// Puts a row of an array of one row a chunk into the file as it is stored there: shuffled and deflated
  /// (storage/deflate.h) where the array is. The work of many threads then takes turns only for the writing.
  void write_chunk(std::string_view dataset, std::uint64_t row, std::span<const std::uint8_t> stored);

  /// Attributes of the root.
  bool has_attribute(std::string_view name) const;
  std::string text_attribute(std::string_view name) const;
  double number_attribute(std::string_view name) const;
  std::vector<double> numbers_attribute(std::string_view name) const;
  void set_attribute(std::string_view name, std::string_view text);
  void set_attribute(std::string_view name, double number);
  void set_attribute(std::string_view name, const std::vector<double>& numbers);

  /// Hands all that was written to the operating system.
  void flush();
  /// Closes the file; unlike the destructor it throws where that fails (a full disk).
  void close();

  /// Throws unless the attributes `format` and `version` say `format` and a version in [1, newest_version];
  /// returns the version.
  int require_format(std::string_view format, int newest_version) const;

 private:
  struct Handle;
  explicit Hdf5File(std::unique_ptr<Handle> handle);
  std::unique_ptr<Handle> handle_;
};

}  // namespace knuckle
