// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_handle.h"

#include <algorithm>
#include <limits>
#include <string>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"

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

constexpr std::uint64_t kDeflatesLimit = 1032;  // 258 bytes for two bits

/// Nothing of a file may make the library load code.
bool refuse_plugins() {
  return H5PLset_loading_state(0) >= 0;
}

}  // namespace

Hdf5Lock::Hdf5Lock() : guard_(library_mutex()) {
  [[maybe_unused]] static const bool is_set_up = leave_open_files_alone();
  [[maybe_unused]] static const bool is_closed = refuse_plugins();
  [[maybe_unused]] thread_local const bool is_silent = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
}

Hdf5Id text_type(std::size_t bytes) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(1, bytes));
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
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
  const std::string text(name);
  H5L_info_t link;
  if (H5Lexists(file, text.c_str(), H5P_DEFAULT) <= 0 ||
      H5Lget_info(file, text.c_str(), &link, H5P_DEFAULT) < 0) {
    fault(name, "the array is missing");
  }
  if (link.type != H5L_TYPE_HARD) fault(name, "is a link; expected the array itself, in this file");
  H5O_info_t object;
  if (H5Oget_info_by_name2(file, text.c_str(), &object, H5O_INFO_BASIC, H5P_DEFAULT) < 0 ||
      object.type != H5O_TYPE_DATASET) {
    fault(name, "expected an array");
  }
  Hdf5Id id(H5Dopen2(file, text.c_str(), H5P_DEFAULT), H5Dclose);
  if (!id.valid()) fault(name, "the array cannot be opened");
  return id;
}

Hdf5Id Hdf5File::Handle::numeric_dataset(std::string_view name) const {
  Hdf5Id id = dataset(name);
  const Hdf5Id type(H5Dget_type(id), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type);
  if (kind != H5T_INTEGER && kind != H5T_FLOAT) fault(name, "expected an array of numbers");
  constexpr std::size_t kLargestNumber = 8;
  if (H5Tget_size(type) > kLargestNumber) fault(name, "expected numbers of at most 8 bytes");
  return id;
}

void Hdf5File::Handle::find_filters(std::string_view name, const Hdf5Id& properties,
                                    Hdf5Dataset& opened) const {
  const int count = H5Pget_nfilters(properties);
  for (int i = 0; i < count; ++i) {
    unsigned flags = 0;
    std::size_t values = 0;
    const H5Z_filter_t filter =
        H5Pget_filter2(properties, static_cast<unsigned>(i), &flags, &values, nullptr, 0, nullptr, nullptr);
    int* place = nullptr;
    if (filter == H5Z_FILTER_SHUFFLE && opened.deflate < 0) place = &opened.shuffle;
    if (filter == H5Z_FILTER_DEFLATE) place = &opened.deflate;
    if (place == nullptr || *place >= 0) {
      fault(name, fmt::format("is stored with the filter {}; expected shuffle and deflate alone", filter));
    }
    *place = i;
  }
}

const Hdf5Dataset& Hdf5File::Handle::kept_dataset(std::string_view name) {
  const Hdf5Lock lock;
  const auto found = kept.find(name);
  if (found != kept.end()) return found->second;
  Hdf5Id id = numeric_dataset(name);
  const Hdf5Id type(H5Dget_type(id), H5Tclose);
  Hdf5Dataset opened{std::move(id), {}, H5Tget_size(type), {}};
  opened.shape = shape(opened.id);
  const Hdf5Id properties(H5Dget_create_plist(opened.id), H5Pclose);
  const H5D_layout_t layout = H5Pget_layout(properties);
  if (H5Pget_external_count(properties) != 0 || layout == H5D_VIRTUAL) {
    fault(name, "is stored in another file; expected all in this one");
  }
  if (layout == H5D_CHUNKED) {
    std::vector<hsize_t> chunk(opened.shape.size());
    const int rank = H5Pget_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
    if (rank < 1 || rank != static_cast<int>(chunk.size())) fault(name, "its chunks have another shape");
    std::uint64_t bytes = opened.number_bytes;
    for (const hsize_t side : chunk) bytes = saturated_product(bytes, side);
    if (bytes == 0 || bytes > static_cast<std::uint64_t>(limits::kChunkBytes)) {
      fault(name,
            fmt::format("is stored in chunks of {} bytes, expected at most {}", bytes, limits::kChunkBytes));
    }
    opened.chunks.assign(chunk.begin(), chunk.end());
    find_filters(name, properties, opened);
  }
  return kept.emplace(name, std::move(opened)).first->second;
}

std::vector<std::uint64_t> Hdf5File::Handle::shape(const Hdf5Id& dataset_id) const {
  const Hdf5Id space(H5Dget_space(dataset_id), H5Sclose);
  std::vector<hsize_t> dimensions(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
  H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
  return {dimensions.begin(), dimensions.end()};
}

std::size_t Hdf5File::Handle::checked_count(std::string_view name, const Hdf5Dataset& dataset) const {
  const Hdf5Lock lock;
  std::uint64_t count = 1;
  for (const std::uint64_t side : dataset.shape) count = saturated_product(count, side);
  const std::uint64_t bytes = saturated_product(count, dataset.number_bytes);
  // What was never written is 0 and takes no room; only little may be so.
  constexpr std::uint64_t kUnwrittenBytes = std::uint64_t{64} << 20;
  const std::uint64_t file_size = std::filesystem::file_size(path);
  const std::uint64_t expansion = dataset.deflate >= 0 ? kDeflatesLimit : 1;
  const std::uint64_t stored = dataset.chunks.empty() ? file_size : H5Dget_storage_size(dataset.id);
  const std::uint64_t most = std::max(saturated_product(std::min(file_size, stored), expansion),
                                      dataset.chunks.empty() ? 0 : kUnwrittenBytes);
  if (bytes > most || bytes > saturated_product(file_size, kDeflatesLimit)) {
    fault(name, fmt::format("declares {} values, more than a file of {} bytes can hold; it is damaged", count,
                            file_size));
  }
  return static_cast<std::size_t>(count);
}

void Hdf5File::Handle::require_one_value(std::string_view name, const Hdf5Id& attribute_id) const {
  const Hdf5Id space(H5Aget_space(attribute_id), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (count != 1) fail("{}: the attribute '{}' has {} values, expected 1", path.string(), name, count);
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
  if (extent.empty() || count > extent[0] || first > extent[0] - count) {
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
