// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_handle.h"

#include <algorithm>
#include <limits>
#include <string>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

std::recursive_mutex& library_mutex() {
  static std::recursive_mutex the_mutex;
  return the_mutex;
}

/// Called before the library's first use: otherwise, at the end of the program, it crashes on a file that
/// could not be closed because the disk was full.
bool leave_open_files_alone() {
  return H5dont_atexit() >= 0;
}

/// a * b, or the largest number where that is more.
std::uint64_t saturated_product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kLargest / b ? kLargest : a * b;
}

/// The most bytes of an array that a byte of the file can stand for.
std::uint64_t largest_expansion(const Hdf5Id& dataset_id) {
  constexpr std::uint64_t kDeflatesLimit = 1032;  // 258 bytes for two bits
  const Hdf5Id properties(H5Dget_create_plist(dataset_id), H5Pclose);
  return H5Pget_layout(properties) == H5D_CHUNKED ? kDeflatesLimit : 1;
}

}  // namespace

Hdf5Lock::Hdf5Lock() : guard_(library_mutex()) {
  [[maybe_unused]] static const bool is_set_up = leave_open_files_alone();
  [[maybe_unused]] thread_local const bool is_silent = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
}

Hdf5Id variable_text_type() {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

std::vector<hsize_t> as_dimensions(const std::vector<std::uint64_t>& shape) {
  return {shape.begin(), shape.end()};
}

Hdf5Id simple_space(const std::vector<std::uint64_t>& shape) {
  const std::vector<hsize_t> dimensions = as_dimensions(shape);
  return {H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), H5Sclose};
}

Hdf5File::Handle::~Handle() {
  const Hdf5Lock lock;
  kept.clear();
  if (file >= 0) H5Fclose(file);
}

void Hdf5File::Handle::fault(std::string_view item, std::string_view message) const {
  fail("{}: {}: {}", path.string(), item, message);
}

Hdf5Id Hdf5File::Handle::dataset(std::string_view name) const {
  if (H5Lexists(file, std::string(name).c_str(), H5P_DEFAULT) <= 0) fault(name, "the array is missing");
  Hdf5Id id(H5Dopen2(file, std::string(name).c_str(), H5P_DEFAULT), H5Dclose);
  if (!id.valid()) fault(name, "the array cannot be opened");
  return id;
}

Hdf5Id Hdf5File::Handle::numeric_dataset(std::string_view name) const {
  Hdf5Id id = dataset(name);
  const Hdf5Id type(H5Dget_type(id), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type);
  if (kind != H5T_INTEGER && kind != H5T_FLOAT) fault(name, "expected an array of numbers");
  return id;
}

const Hdf5File::Handle::KeptDataset& Hdf5File::Handle::kept_dataset(std::string_view name) {
  const auto found = kept.find(name);
  if (found != kept.end()) return found->second;
  Hdf5Id id = numeric_dataset(name);
  const std::size_t rank = shape(id).size();
  return kept.emplace(name, KeptDataset{std::move(id), rank}).first->second;
}

std::vector<std::uint64_t> Hdf5File::Handle::shape(const Hdf5Id& dataset_id) const {
  const Hdf5Id space(H5Dget_space(dataset_id), H5Sclose);
  std::vector<hsize_t> dimensions(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
  return {dimensions.begin(), dimensions.end()};
}

std::size_t Hdf5File::Handle::checked_count(std::string_view name, const Hdf5Id& dataset_id) const {
  const Hdf5Id type(H5Dget_type(dataset_id), H5Tclose);
  std::uint64_t count = 1;
  for (const std::uint64_t side : shape(dataset_id)) count = saturated_product(count, side);
  const std::uint64_t file_size = std::filesystem::file_size(path);
  if (saturated_product(count, H5Tget_size(type)) >
      saturated_product(file_size, largest_expansion(dataset_id))) {
    fault(name, fmt::format("declares {} values, more than a file of {} bytes can hold; it is damaged", count,
                            file_size));
  }
  return static_cast<std::size_t>(count);
}

void Hdf5File::Handle::check_attribute_size(std::string_view name, std::uint64_t bytes) const {
  const std::uint64_t file_size = std::filesystem::file_size(path);
  if (bytes <= file_size) return;
  fail("{}: the attribute '{}' declares {} bytes, more than the file's {}; it is damaged", path.string(),
       name, bytes, file_size);
}

Hdf5Id Hdf5File::Handle::row_selection(std::string_view name, const Hdf5Id& dataset_id, std::uint64_t first,
                                       std::uint64_t count) const {
  std::vector<std::uint64_t> extent = shape(dataset_id);
  if (extent.empty() || first + count > extent[0]) {
    fault(name, fmt::format("rows {} to {} were asked for, it has {}", first, first + count,
                            extent.empty() ? 0 : extent[0]));
  }
  std::vector<hsize_t> start(extent.size(), 0);
  std::vector<hsize_t> size = as_dimensions(extent);
  start[0] = first;
  size[0] = count;
  Hdf5Id space(H5Dget_space(dataset_id), H5Sclose);
  H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
  return space;
}

Hdf5Id Hdf5File::Handle::rows_in_memory(const Hdf5Id& dataset_id, std::uint64_t count) const {
  std::vector<std::uint64_t> extent = shape(dataset_id);
  extent[0] = count;
  return simple_space(extent);
}

Hdf5Id Hdf5File::Handle::attribute(std::string_view name) const {
  if (H5Aexists(file, std::string(name).c_str()) <= 0)
    fail("{}: the attribute '{}' is missing", path.string(), name);
  return {H5Aopen(file, std::string(name).c_str(), H5P_DEFAULT), H5Aclose};
}

Hdf5Id Hdf5File::Handle::new_attribute(std::string_view name, hid_t type, const Hdf5Id& space) const {
  const std::string text(name);
  if (H5Aexists(file, text.c_str()) > 0) H5Adelete(file, text.c_str());
  Hdf5Id id(H5Acreate2(file, text.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!id.valid()) fail("{}: cannot write the attribute '{}'", path.string(), name);
  return id;
}

}  // namespace knuckle
