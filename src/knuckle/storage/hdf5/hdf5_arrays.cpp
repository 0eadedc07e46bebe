// SPDX-License-Identifier: Apache-2.0
// Arrays of numbers.
#include <functional>
#include <numeric>
#include <string>

#include "knuckle/storage/hdf5/hdf5_handle.h"

namespace knuckle {
namespace {

template <class T>
hid_t native_type();
template <>
hid_t native_type<float>() {
  return H5T_NATIVE_FLOAT;
}
template <>
hid_t native_type<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t native_type<std::int8_t>() {
  return H5T_NATIVE_INT8;
}
template <>
hid_t native_type<std::uint8_t>() {
  return H5T_NATIVE_UINT8;
}
template <>
hid_t native_type<std::int16_t>() {
  return H5T_NATIVE_INT16;
}
template <>
hid_t native_type<std::uint16_t>() {
  return H5T_NATIVE_UINT16;
}
template <>
hid_t native_type<std::int32_t>() {
  return H5T_NATIVE_INT32;
}
template <>
hid_t native_type<std::uint32_t>() {
  return H5T_NATIVE_UINT32;
}
template <>
hid_t native_type<std::int64_t>() {
  return H5T_NATIVE_INT64;
}
template <>
hid_t native_type<std::uint64_t>() {
  return H5T_NATIVE_UINT64;
}

std::uint64_t product(const std::vector<std::uint64_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, std::multiplies<>());
}

/// Without time stamps: the same content makes the same bytes.
Hdf5Id creation_properties() {
  Hdf5Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, static_cast<hbool_t>(0));
  return properties;
}

}  // namespace

bool Hdf5File::has(std::string_view dataset) const {
  const Hdf5Lock lock;
  return H5Lexists(handle_->file, std::string(dataset).c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::uint64_t> Hdf5File::shape(std::string_view dataset) const {
  const Hdf5Dataset& kept = handle_->kept_dataset(dataset);
  handle_->checked_count(dataset, kept);
  return kept.shape;
}

template <class T>
Hdf5Array<T> Hdf5File::read(std::string_view dataset) const {
  const Hdf5Dataset& kept = handle_->kept_dataset(dataset);
  Hdf5Array<T> array;
  array.shape = kept.shape;
  array.values.resize(handle_->checked_count(dataset, kept));
  if (array.shape.empty()) handle_->fault(dataset, "expected an array, found a single number");
  if (!array.values.empty()) read_rows(dataset, 0, array.shape[0], array.values.data());
  return array;
}

template <class T>
void Hdf5File::read_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count,
                         T* values) const {
  const Hdf5Dataset& kept = handle_->kept_dataset(dataset);
  if (!kept.chunks.empty())
    return handle_->read_chunked(dataset, kept, first, count, native_type<T>(), sizeof(T), values);
  const Hdf5Lock lock;
  const Hdf5Id selection = handle_->row_selection(dataset, kept.id, first, count);
  const Hdf5Id memory = handle_->rows_in_memory(kept.id, count);
  if (H5Dread(kept.id, native_type<T>(), memory, selection, H5P_DEFAULT, values) < 0) {
    handle_->fault(dataset, "rows cannot be read; the file is damaged");
  }
}

template <class T>
void Hdf5File::create_dataset(std::string_view dataset, const std::vector<std::uint64_t>& shape,
                              const Storage& storage) {
  const Hdf5Lock lock;
  const Hdf5Id space = simple_space(shape);
  const Hdf5Id properties = creation_properties();
  if (storage.rows_per_chunk > 0 && product(shape) > 0) {
    std::vector<hsize_t> chunk = as_dimensions(shape);
    chunk[0] = std::min<hsize_t>(storage.rows_per_chunk, shape[0]);
    H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
    if (storage.deflate_level > 0) {
      H5Pset_shuffle(properties);
      H5Pset_deflate(properties, static_cast<unsigned>(storage.deflate_level));
    }
  }
  const Hdf5Id id(H5Dcreate2(handle_->file, std::string(dataset).c_str(), native_type<T>(), space,
                             H5P_DEFAULT, properties, H5P_DEFAULT),
                  H5Dclose);
  if (!id.valid()) handle_->fault(dataset, "the array cannot be made");
}

template <class T>
void Hdf5File::write(std::string_view dataset, const std::vector<std::uint64_t>& shape, const T* values,
                     const Storage& storage) {
  const Hdf5Lock lock;
  create_dataset<T>(dataset, shape, storage);
  const Hdf5Id id = handle_->dataset(dataset);
  if (product(shape) > 0 && H5Dwrite(id, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
    handle_->fault(dataset, "cannot be written; is the disk full?");
  }
}

template <class T>
void Hdf5File::write_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count,
                          const T* values) {
  const Hdf5Lock lock;
  const Hdf5Id id = handle_->numeric_dataset(dataset);
  const Hdf5Id selection = handle_->row_selection(dataset, id, first, count);
  const Hdf5Id memory = handle_->rows_in_memory(id, count);
  if (H5Dwrite(id, native_type<T>(), memory, selection, H5P_DEFAULT, values) < 0) {
    handle_->fault(dataset, "cannot be written; is the disk full?");
  }
}

void Hdf5File::write_chunk(std::string_view dataset, std::uint64_t row,
                           std::span<const std::uint8_t> stored) {
  const Hdf5Lock lock;
  const Hdf5Dataset& kept = handle_->kept_dataset(dataset);
  std::vector<hsize_t> place(kept.shape.size(), 0);
  if (place.empty()) handle_->fault(dataset, "has no rows");
  place[0] = row;
  constexpr std::uint32_t kAllFiltersApplied = 0;
  if (H5Dwrite_chunk(kept.id, H5P_DEFAULT, kAllFiltersApplied, place.data(), stored.size(), stored.data()) <
      0) {
    handle_->fault(dataset, "cannot be written; is the disk full?");
  }
}

#define KNUCKLE_INSTANTIATE(T)                                                                    \
  template Hdf5Array<T> Hdf5File::read<T>(std::string_view) const;                                \
  template void Hdf5File::read_rows<T>(std::string_view, std::uint64_t, std::uint64_t, T*) const; \
  template void Hdf5File::write<T>(std::string_view, const std::vector<std::uint64_t>&, const T*, \
                                   const Storage&);                                               \
  template void Hdf5File::create_dataset<T>(std::string_view, const std::vector<std::uint64_t>&,  \
                                            const Storage&);                                      \
  template void Hdf5File::write_rows<T>(std::string_view, std::uint64_t, std::uint64_t, const T*);
KNUCKLE_INSTANTIATE(float)
KNUCKLE_INSTANTIATE(double)
KNUCKLE_INSTANTIATE(std::int8_t)
KNUCKLE_INSTANTIATE(std::uint8_t)
KNUCKLE_INSTANTIATE(std::int16_t)
KNUCKLE_INSTANTIATE(std::uint16_t)
KNUCKLE_INSTANTIATE(std::int32_t)
KNUCKLE_INSTANTIATE(std::uint32_t)
KNUCKLE_INSTANTIATE(std::int64_t)
KNUCKLE_INSTANTIATE(std::uint64_t)
#undef KNUCKLE_INSTANTIATE

}  // namespace knuckle
