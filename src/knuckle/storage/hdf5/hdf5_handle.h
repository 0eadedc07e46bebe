// SPDX-License-Identifier: Apache-2.0
// What the parts of Hdf5File share; only its own sources include this.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <hdf5.h>

#include "knuckle/storage/hdf5/hdf5_file.h"

namespace knuckle {

/// HDF5 keeps global state: every call of the library happens under this lock. Each thread is told once not
/// to print the library's own stack of errors.
class Hdf5Lock {
 public:
  Hdf5Lock();

 private:
  std::lock_guard<std::recursive_mutex> guard_;
};

/// An identifier of the library with the function that gives it back.
class Hdf5Id {
 public:
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Id(Hdf5Id&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Id& operator=(Hdf5Id&&) = delete;
  ~Hdf5Id() {
    if (id_ >= 0) close_(id_);
  }
  bool valid() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// The type of texts in our files: UTF-8 of that many bytes.
Hdf5Id text_type(std::size_t bytes);
/// The shape in the type that HDF5 asks for.
std::vector<hsize_t> as_dimensions(const std::vector<std::uint64_t>& shape);
/// A data space of that shape.
Hdf5Id simple_space(const std::vector<std::uint64_t>& shape);

/// An array that stays open with its file.
struct Hdf5Dataset {
  Hdf5Id id;
  std::vector<std::uint64_t> shape;
  std::size_t number_bytes;           ///< of a number as it is stored
  std::vector<std::uint64_t> chunks;  ///< shape of a chunk; empty where the array lies in one piece
  int shuffle = -1;                   ///< the filter's place among all; -1: there is none
  int deflate = -1;
};

/// An open file with its path, for messages; closed in the end.
struct Hdf5File::Handle {
  std::filesystem::path path;
  hid_t file = H5I_INVALID_HID;
  std::map<std::string, Hdf5Dataset, std::less<>> kept;  ///< changed under the lock; what is in it stays

  Handle(std::filesystem::path file_path, hid_t id) : path(std::move(file_path)), file(id) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle();

  [[noreturn]] void fault(std::string_view item, std::string_view message) const;

  Hdf5Id dataset(std::string_view name) const;
  /// The same, kept open until the file is closed: for what is asked for again and again.
  const Hdf5Dataset& kept_dataset(std::string_view name);
  Hdf5Id numeric_dataset(std::string_view name) const;
  void find_filters(std::string_view name, const Hdf5Id& properties, Hdf5Dataset& opened) const;
  std::vector<std::uint64_t> shape(const Hdf5Id& dataset_id) const;
  /// Number of values. Throws where they are more than a file of this size can hold: a damaged file must not
  /// decide how much memory is taken.
  std::size_t checked_count(std::string_view name, const Hdf5Dataset& dataset) const;
  /// Reads rows of an array in chunks, which are inflated outside of the library and its lock. `values` has
  /// room for them as numbers of the memory's type.
  void read_chunked(std::string_view name, const Hdf5Dataset& dataset, std::uint64_t first,
                    std::uint64_t count, hid_t memory_type, std::size_t memory_bytes, void* values) const;
  /// A chunk's bytes as they are stored, and which filters were left out; none where it was never written.
  std::vector<std::uint8_t> stored_chunk(std::string_view name, const Hdf5Dataset& dataset,
                                         const std::vector<std::uint64_t>& place,
                                         std::uint32_t& left_out) const;
  /// A chunk's numbers.
  std::vector<std::uint8_t> chunk(std::string_view name, const Hdf5Dataset& dataset,
                                  const std::vector<std::uint64_t>& place) const;
  /// The one value of an attribute. Throws where it has more, or none.
  void require_one_value(std::string_view name, const Hdf5Id& attribute_id) const;
  /// The same of an attribute's `bytes`.
  void check_attribute_size(std::string_view name, std::uint64_t bytes) const;
  /// The part of a dataset that holds rows [first, first + count).
  Hdf5Id row_selection(std::string_view name, const Hdf5Id& dataset_id, std::uint64_t first,
                       std::uint64_t count) const;
  Hdf5Id rows_in_memory(const Hdf5Id& dataset_id, std::uint64_t count) const;
  Hdf5Id attribute(std::string_view name) const;
  Hdf5Id new_attribute(std::string_view name, hid_t type, const Hdf5Id& space) const;
};

}  // namespace knuckle
