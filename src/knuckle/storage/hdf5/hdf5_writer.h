// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace knuckle {

/// Writes HDF5 files, with libhdf5, in the format that every version of it reads. T is one of the types that
/// Hdf5File reads. The library is not made for threads: all calls of all files take turns.
class Hdf5Writer {
 public:
  /// Replaces a file of that name. Throws an Error that names it where it cannot be written.
  static Hdf5Writer create(const std::filesystem::path& path);
  /// Adds to a file that this program wrote itself: the library crashes on damaged ones.
  static Hdf5Writer open(const std::filesystem::path& path);

  Hdf5Writer(Hdf5Writer&&) noexcept;
  Hdf5Writer& operator=(Hdf5Writer&&) noexcept;
  ~Hdf5Writer();

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
  void set_attribute(std::string_view name, std::string_view text);
  void set_attribute(std::string_view name, double number);
  void set_attribute(std::string_view name, const std::vector<double>& numbers);

  /// Hands all that was written to the operating system.
  void flush();
  /// Closes the file; unlike the destructor it throws where that fails (a full disk).
  void close();

 private:
  struct Handle;
  explicit Hdf5Writer(std::unique_ptr<Handle> handle);
  std::unique_ptr<Handle> handle_;
};

}  // namespace knuckle
