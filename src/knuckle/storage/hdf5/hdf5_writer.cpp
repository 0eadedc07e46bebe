// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_writer.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>

#include <hdf5.h>

#include "knuckle/core/error.h"

namespace knuckle {

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

namespace {

std::recursive_mutex& library_mutex() {
  static std::recursive_mutex the_mutex;
  return the_mutex;
}

/// HDF5 keeps global state: every call of the library happens under this lock. Each thread is told once not
/// to print the library's own stack of errors.
class Hdf5Lock {
 public:
  Hdf5Lock() : guard_(library_mutex()) {
    // Before the library's first use: otherwise, at the end of the program, it crashes on a file that could
    // not be closed because the disk was full.
    [[maybe_unused]] static const bool leaves_open_files_alone = H5dont_atexit() >= 0;
    [[maybe_unused]] static const bool loads_no_plugins = H5PLset_loading_state(0) >= 0;
    [[maybe_unused]] thread_local const bool is_silent = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  }

 private:
  std::lock_guard<std::recursive_mutex> guard_;
};

template <class T>
hid_t native_type() {
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, std::int8_t>) return H5T_NATIVE_INT8;
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_NATIVE_UINT8;
  if constexpr (std::is_same_v<T, std::int16_t>) return H5T_NATIVE_INT16;
  if constexpr (std::is_same_v<T, std::uint16_t>) return H5T_NATIVE_UINT16;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_NATIVE_UINT32;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_NATIVE_UINT64;
}

/// A data space of that shape.
Hdf5Id simple_space(const std::vector<std::uint64_t>& shape) {
  const std::vector<hsize_t> dimensions(shape.begin(), shape.end());
  return {H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), H5Sclose};
}

/// The type of texts in our files: UTF-8 of that many bytes.
Hdf5Id text_type(std::size_t bytes) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(1, bytes));
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

/// Without time stamps: the same content makes the same bytes.
Hdf5Id creation_properties() {
  Hdf5Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, static_cast<hbool_t>(0));
  return properties;
}

bool is_empty(const std::vector<std::uint64_t>& shape) {
  return std::ranges::find(shape, std::uint64_t{0}) != shape.end();
}

}  // namespace

/// An open file with its path, for messages; closed in the end.
struct Hdf5Writer::Handle {
  std::filesystem::path path;
  hid_t file = H5I_INVALID_HID;
  std::map<std::string, Hdf5Id, std::less<>> datasets;  ///< open with the file

  Handle(std::filesystem::path file_path, hid_t id) : path(std::move(file_path)), file(id) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    const Hdf5Lock lock;
    datasets.clear();
    if (file >= 0) H5Fclose(file);
  }

  [[noreturn]] void fault(std::string_view item, std::string_view message) const {
    fail("{}: {}: {}", path.string(), item, message);
  }
  [[noreturn]] void cannot_write(std::string_view dataset) const {
    fault(dataset, "cannot be written; is the disk full?");
  }

  hid_t dataset(std::string_view name) {
    const auto found = datasets.find(name);
    if (found != datasets.end()) return found->second;
    Hdf5Id id(H5Dopen2(file, std::string(name).c_str(), H5P_DEFAULT), H5Dclose);
    if (!id.valid()) fault(name, "the array is missing");
    return datasets.emplace(name, std::move(id)).first->second;
  }

  std::vector<hsize_t> shape(hid_t dataset_id) const {
    const Hdf5Id space(H5Dget_space(dataset_id), H5Sclose);
    std::vector<hsize_t> sides(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    H5Sget_simple_extent_dims(space, sides.data(), nullptr);
    return sides;
  }

  void write_attribute(std::string_view name, hid_t type, const Hdf5Id& space, const void* values) const {
    const std::string text(name);
    if (H5Aexists(file, text.c_str()) > 0) H5Adelete(file, text.c_str());
    const Hdf5Id id(H5Acreate2(file, text.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!id.valid() || H5Awrite(id, type, values) < 0)
      fail("{}: cannot write the attribute '{}'", path.string(), name);
  }
};

Hdf5Writer::Hdf5Writer(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
Hdf5Writer::Hdf5Writer(Hdf5Writer&&) noexcept = default;
Hdf5Writer& Hdf5Writer::operator=(Hdf5Writer&&) noexcept = default;
Hdf5Writer::~Hdf5Writer() = default;

Hdf5Writer Hdf5Writer::create(const std::filesystem::path& path) {
  const Hdf5Lock lock;
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (file < 0) fail("{}: cannot write the HDF5 file", path.string());
  return Hdf5Writer(std::make_unique<Handle>(path, file));
}

Hdf5Writer Hdf5Writer::open(const std::filesystem::path& path) {
  const Hdf5Lock lock;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  if (file < 0) fail("{}: the HDF5 file is missing, damaged, or in use", path.string());
  return Hdf5Writer(std::make_unique<Handle>(path, file));
}

template <class T>
void Hdf5Writer::create_dataset(std::string_view dataset, const std::vector<std::uint64_t>& shape,
                                const Storage& storage) {
  const Hdf5Lock lock;
  const Hdf5Id space = simple_space(shape);
  const Hdf5Id properties = creation_properties();
  if (storage.rows_per_chunk > 0 && !shape.empty() && !is_empty(shape)) {
    std::vector<hsize_t> chunk(shape.begin(), shape.end());
    chunk[0] = std::min<hsize_t>(storage.rows_per_chunk, shape[0]);
    H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
    if (storage.deflate_level > 0) {
      H5Pset_shuffle(properties);
      H5Pset_deflate(properties, static_cast<unsigned>(storage.deflate_level));
    }
  }
  Hdf5Id id(H5Dcreate2(handle_->file, std::string(dataset).c_str(), native_type<T>(), space, H5P_DEFAULT,
                       properties, H5P_DEFAULT),
            H5Dclose);
  if (!id.valid()) handle_->fault(dataset, "the array cannot be made");
  handle_->datasets.emplace(dataset, std::move(id));
}

template <class T>
void Hdf5Writer::write(std::string_view dataset, const std::vector<std::uint64_t>& shape, const T* values,
                       const Storage& storage) {
  const Hdf5Lock lock;
  create_dataset<T>(dataset, shape, storage);
  if (is_empty(shape)) return;
  if (H5Dwrite(handle_->dataset(dataset), native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0)
    handle_->cannot_write(dataset);
}

template <class T>
void Hdf5Writer::write_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count,
                            const T* values) {
  const Hdf5Lock lock;
  const hid_t id = handle_->dataset(dataset);
  std::vector<hsize_t> size = handle_->shape(id);
  if (size.empty() || count > size[0] || first > size[0] - count)
    handle_->fault(dataset, fmt::format("has no rows {} to {}", first, first + count));
  std::vector<hsize_t> start(size.size(), 0);
  start[0] = first;
  size[0] = count;
  const Hdf5Id selection(H5Dget_space(id), H5Sclose);
  H5Sselect_hyperslab(selection, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
  const Hdf5Id memory = simple_space({size.begin(), size.end()});
  if (H5Dwrite(id, native_type<T>(), memory, selection, H5P_DEFAULT, values) < 0)
    handle_->cannot_write(dataset);
}

void Hdf5Writer::write_chunk(std::string_view dataset, std::uint64_t row,
                             std::span<const std::uint8_t> stored) {
  const Hdf5Lock lock;
  const hid_t id = handle_->dataset(dataset);
  std::vector<hsize_t> place(handle_->shape(id).size(), 0);
  if (place.empty()) handle_->fault(dataset, "has no rows");
  place[0] = row;
  constexpr std::uint32_t kAllFiltersApplied = 0;
  if (H5Dwrite_chunk(id, H5P_DEFAULT, kAllFiltersApplied, place.data(), stored.size(), stored.data()) < 0)
    handle_->cannot_write(dataset);
}

void Hdf5Writer::set_attribute(std::string_view name, std::string_view text) {
  const Hdf5Lock lock;
  // HDF5 holds no longer ones without another kind of storage: such a text is an array of bytes.
  constexpr std::size_t kLongestAttribute = 60000;
  if (text.size() > kLongestAttribute)
    return write(name, {text.size()}, reinterpret_cast<const std::uint8_t*>(text.data()));
  const std::string owned(text);
  handle_->write_attribute(name, text_type(owned.size()), {H5Screate(H5S_SCALAR), H5Sclose}, owned.c_str());
}

void Hdf5Writer::set_attribute(std::string_view name, double number) {
  const Hdf5Lock lock;
  handle_->write_attribute(name, H5T_NATIVE_DOUBLE, {H5Screate(H5S_SCALAR), H5Sclose}, &number);
}

void Hdf5Writer::set_attribute(std::string_view name, const std::vector<double>& numbers) {
  const Hdf5Lock lock;
  handle_->write_attribute(name, H5T_NATIVE_DOUBLE, simple_space({numbers.size()}), numbers.data());
}

void Hdf5Writer::flush() {
  const Hdf5Lock lock;
  if (H5Fflush(handle_->file, H5F_SCOPE_GLOBAL) < 0)
    fail("{}: cannot be written; is the disk full?", handle_->path.string());
}

void Hdf5Writer::close() {
  const Hdf5Lock lock;
  if (handle_->file < 0) return;
  flush();
  handle_->datasets.clear();
  if (H5Fclose(std::exchange(handle_->file, H5I_INVALID_HID)) < 0)
    fail("{}: cannot be written; is the disk full?", handle_->path.string());
}

#define KNUCKLE_INSTANTIATE(T)                                                                     \
  template void Hdf5Writer::write(std::string_view, const std::vector<std::uint64_t>&, const T*,   \
                                  const Storage&);                                                 \
  template void Hdf5Writer::create_dataset<T>(std::string_view, const std::vector<std::uint64_t>&, \
                                              const Storage&);                                     \
  template void Hdf5Writer::write_rows(std::string_view, std::uint64_t, std::uint64_t, const T*);
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
