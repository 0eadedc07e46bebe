// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/hdf5_file.h"

#include <functional>
#include <mutex>
#include <numeric>
#include <utility>

#include <hdf5.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// Called before the library's first use: otherwise, at the end of the program, it crashes on a file that
/// could not be closed because the disk was full.
bool leave_open_files_alone() {
  return H5dont_atexit() >= 0;
}

/// HDF5 keeps global state: every call of the library happens under this lock. Each thread is told once not
/// to print the library's own stack of errors.
class Lock {
 public:
  Lock() : guard_(mutex()) {
    [[maybe_unused]] static const bool is_set_up = leave_open_files_alone();
    [[maybe_unused]] thread_local const bool is_silent = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  }

 private:
  static std::recursive_mutex& mutex() {
    static std::recursive_mutex the_mutex;
    return the_mutex;
  }

  std::lock_guard<std::recursive_mutex> guard_;
};

/// An identifier of the library with the function that gives it back.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Id(Id&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Id& operator=(Id&&) = delete;
  ~Id() {
    if (id_ >= 0) close_(id_);
  }
  bool valid() const { return id_ >= 0; }
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

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

std::vector<hsize_t> as_dimensions(const std::vector<std::uint64_t>& shape) {
  return {shape.begin(), shape.end()};
}

Id simple_space(const std::vector<std::uint64_t>& shape) {
  const std::vector<hsize_t> dimensions = as_dimensions(shape);
  return {H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), H5Sclose};
}

/// Without time stamps: the same content makes the same bytes.
Id creation_properties() {
  Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(properties, static_cast<hbool_t>(0));
  return properties;
}

Id variable_text_type() {
  Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

}  // namespace

struct Hdf5File::Handle {
  std::filesystem::path path;
  hid_t file = H5I_INVALID_HID;

  Handle(std::filesystem::path file_path, hid_t id) : path(std::move(file_path)), file(id) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    const Lock lock;
    if (file >= 0) H5Fclose(file);
  }

  [[noreturn]] void fault(std::string_view item, std::string_view message) const {
    fail("{}: {}: {}", path.string(), item, message);
  }

  Id dataset(std::string_view name) const {
    if (H5Lexists(file, std::string(name).c_str(), H5P_DEFAULT) <= 0) fault(name, "the array is missing");
    Id id(H5Dopen2(file, std::string(name).c_str(), H5P_DEFAULT), H5Dclose);
    if (!id.valid()) fault(name, "the array cannot be opened");
    return id;
  }

  Id numeric_dataset(std::string_view name) const {
    Id id = dataset(name);
    const Id type(H5Dget_type(id), H5Tclose);
    const H5T_class_t kind = H5Tget_class(type);
    if (kind != H5T_INTEGER && kind != H5T_FLOAT) fault(name, "expected an array of numbers");
    return id;
  }

  std::vector<std::uint64_t> shape(const Id& dataset_id) const {
    const Id space(H5Dget_space(dataset_id), H5Sclose);
    std::vector<hsize_t> dimensions(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    H5Sget_simple_extent_dims(space, dimensions.data(), nullptr);
    return {dimensions.begin(), dimensions.end()};
  }

  /// The part of a dataset that holds rows [first, first + count).
  Id row_selection(std::string_view name, const Id& dataset_id, std::uint64_t first,
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
    Id space(H5Dget_space(dataset_id), H5Sclose);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr);
    return space;
  }

  Id rows_in_memory(const Id& dataset_id, std::uint64_t count) const {
    std::vector<std::uint64_t> extent = shape(dataset_id);
    extent[0] = count;
    return simple_space(extent);
  }

  Id attribute(std::string_view name) const {
    if (H5Aexists(file, std::string(name).c_str()) <= 0)
      fail("{}: the attribute '{}' is missing", path.string(), name);
    return {H5Aopen(file, std::string(name).c_str(), H5P_DEFAULT), H5Aclose};
  }

  Id new_attribute(std::string_view name, hid_t type, const Id& space) const {
    const std::string text(name);
    if (H5Aexists(file, text.c_str()) > 0) H5Adelete(file, text.c_str());
    Id id(H5Acreate2(file, text.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (!id.valid()) fail("{}: cannot write the attribute '{}'", path.string(), name);
    return id;
  }
};

Hdf5File::Hdf5File(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

namespace {

hid_t open_with(const std::filesystem::path& path, unsigned mode) {
  if (!std::filesystem::exists(path)) fail("{}: the file is missing", path.string());
  if (std::filesystem::is_directory(path)) fail("{}: expected a file, found a folder", path.string());
  if (H5Fis_hdf5(path.c_str()) <= 0) fail("{}: no HDF5 file, or its beginning is damaged", path.string());
  const hid_t file = H5Fopen(path.c_str(), mode, H5P_DEFAULT);
  if (file < 0) fail("{}: the HDF5 file is cut short, damaged, or in use", path.string());
  return file;
}

}  // namespace

Hdf5File Hdf5File::open(const std::filesystem::path& path) {
  const Lock lock;
  return Hdf5File(std::make_unique<Handle>(path, open_with(path, H5F_ACC_RDONLY)));
}

Hdf5File Hdf5File::open_for_writing(const std::filesystem::path& path) {
  const Lock lock;
  return Hdf5File(std::make_unique<Handle>(path, open_with(path, H5F_ACC_RDWR)));
}

Hdf5File Hdf5File::create(const std::filesystem::path& path) {
  const Lock lock;
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (file < 0) fail("{}: cannot write the HDF5 file", path.string());
  return Hdf5File(std::make_unique<Handle>(path, file));
}

const std::filesystem::path& Hdf5File::path() const {
  return handle_->path;
}

bool Hdf5File::has(std::string_view dataset) const {
  const Lock lock;
  return H5Lexists(handle_->file, std::string(dataset).c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::uint64_t> Hdf5File::shape(std::string_view dataset) const {
  const Lock lock;
  return handle_->shape(handle_->dataset(dataset));
}

template <class T>
Hdf5Array<T> Hdf5File::read(std::string_view dataset) const {
  const Lock lock;
  const Id id = handle_->numeric_dataset(dataset);
  Hdf5Array<T> array;
  array.shape = handle_->shape(id);
  array.values.resize(product(array.shape));
  if (H5Dread(id, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) < 0) {
    handle_->fault(dataset, "the array cannot be read; the file is damaged");
  }
  return array;
}

template <class T>
void Hdf5File::read_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count,
                         T* values) const {
  const Lock lock;
  const Id id = handle_->numeric_dataset(dataset);
  const Id selection = handle_->row_selection(dataset, id, first, count);
  const Id memory = handle_->rows_in_memory(id, count);
  if (H5Dread(id, native_type<T>(), memory, selection, H5P_DEFAULT, values) < 0) {
    handle_->fault(dataset, "rows cannot be read; the file is damaged");
  }
}

template <class T>
void Hdf5File::create_dataset(std::string_view dataset, const std::vector<std::uint64_t>& shape,
                              const Storage& storage) {
  const Lock lock;
  const Id space = simple_space(shape);
  const Id properties = creation_properties();
  if (storage.rows_a_chunk > 0 && product(shape) > 0) {
    std::vector<hsize_t> chunk = as_dimensions(shape);
    chunk[0] = std::min<hsize_t>(storage.rows_a_chunk, shape[0]);
    H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
    if (storage.deflate_level > 0) {
      H5Pset_shuffle(properties);
      H5Pset_deflate(properties, static_cast<unsigned>(storage.deflate_level));
    }
  }
  const Id id(H5Dcreate2(handle_->file, std::string(dataset).c_str(), native_type<T>(), space, H5P_DEFAULT,
                         properties, H5P_DEFAULT),
              H5Dclose);
  if (!id.valid()) handle_->fault(dataset, "the array cannot be made");
}

template <class T>
void Hdf5File::write(std::string_view dataset, const std::vector<std::uint64_t>& shape, const T* values,
                     const Storage& storage) {
  const Lock lock;
  create_dataset<T>(dataset, shape, storage);
  const Id id = handle_->dataset(dataset);
  if (product(shape) > 0 && H5Dwrite(id, native_type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
    handle_->fault(dataset, "cannot be written; is the disk full?");
  }
}

template <class T>
void Hdf5File::write_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count,
                          const T* values) {
  const Lock lock;
  const Id id = handle_->numeric_dataset(dataset);
  const Id selection = handle_->row_selection(dataset, id, first, count);
  const Id memory = handle_->rows_in_memory(id, count);
  if (H5Dwrite(id, native_type<T>(), memory, selection, H5P_DEFAULT, values) < 0) {
    handle_->fault(dataset, "cannot be written; is the disk full?");
  }
}

std::vector<std::string> Hdf5File::read_texts(std::string_view dataset) const {
  const Lock lock;
  const Id id = handle_->dataset(dataset);
  const Id file_type(H5Dget_type(id), H5Tclose);
  if (H5Tget_class(file_type) != H5T_STRING || H5Tis_variable_str(file_type) <= 0) {
    handle_->fault(dataset, "expected an array of texts");
  }
  std::vector<char*> pointers(product(handle_->shape(id)), nullptr);
  const Id type = variable_text_type();
  if (H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0) {
    handle_->fault(dataset, "the texts cannot be read; the file is damaged");
  }
  std::vector<std::string> texts;
  for (const char* pointer : pointers) texts.emplace_back(pointer == nullptr ? "" : pointer);
  const Id space(H5Dget_space(id), H5Sclose);
  H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
  return texts;
}

void Hdf5File::write_texts(std::string_view dataset, const std::vector<std::string>& texts) {
  const Lock lock;
  std::vector<const char*> pointers;
  for (const std::string& text : texts) pointers.push_back(text.c_str());
  const Id type = variable_text_type();
  const Id space = simple_space({texts.size()});
  const Id properties = creation_properties();
  const Id id(H5Dcreate2(handle_->file, std::string(dataset).c_str(), type, space, H5P_DEFAULT, properties,
                         H5P_DEFAULT),
              H5Dclose);
  if (!id.valid() || H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0) {
    handle_->fault(dataset, "cannot be written; is the disk full?");
  }
}

bool Hdf5File::has_attribute(std::string_view name) const {
  const Lock lock;
  return H5Aexists(handle_->file, std::string(name).c_str()) > 0;
}

std::string Hdf5File::text_attribute(std::string_view name) const {
  const Lock lock;
  const Id id = handle_->attribute(name);
  const Id file_type(H5Aget_type(id), H5Tclose);
  if (H5Tget_class(file_type) != H5T_STRING) fail("{}: the attribute '{}' is no text", path().string(), name);
  if (H5Tis_variable_str(file_type) > 0) {
    char* pointer = nullptr;
    const Id type = variable_text_type();
    if (H5Aread(id, type, &pointer) < 0 || pointer == nullptr) {
      fail("{}: the attribute '{}' cannot be read", path().string(), name);
    }
    std::string text(pointer);
    H5free_memory(pointer);
    return text;
  }
  std::string text(H5Tget_size(file_type), '\0');
  if (H5Aread(id, file_type, text.data()) < 0)
    fail("{}: the attribute '{}' cannot be read", path().string(), name);
  return text.substr(0, text.find('\0'));
}

double Hdf5File::number_attribute(std::string_view name) const {
  const std::vector<double> numbers = numbers_attribute(name);
  if (numbers.size() != 1)
    fail("{}: the attribute '{}' holds {} numbers, expected 1", path().string(), name, numbers.size());
  return numbers[0];
}

std::vector<double> Hdf5File::numbers_attribute(std::string_view name) const {
  const Lock lock;
  const Id id = handle_->attribute(name);
  const Id type(H5Aget_type(id), H5Tclose);
  if (H5Tget_class(type) != H5T_INTEGER && H5Tget_class(type) != H5T_FLOAT) {
    fail("{}: the attribute '{}' is no number", path().string(), name);
  }
  const Id space(H5Aget_space(id), H5Sclose);
  std::vector<double> numbers(
      static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space))));
  if (H5Aread(id, H5T_NATIVE_DOUBLE, numbers.data()) < 0) {
    fail("{}: the attribute '{}' cannot be read", path().string(), name);
  }
  return numbers;
}

void Hdf5File::set_attribute(std::string_view name, std::string_view text) {
  const Lock lock;
  const std::string owned(text);
  const char* pointer = owned.c_str();
  const Id type = variable_text_type();
  const Id id = handle_->new_attribute(name, type, Id(H5Screate(H5S_SCALAR), H5Sclose));
  if (H5Awrite(id, type, &pointer) < 0) fail("{}: cannot write the attribute '{}'", path().string(), name);
}

void Hdf5File::set_attribute(std::string_view name, double number) {
  const Lock lock;
  const Id id = handle_->new_attribute(name, H5T_NATIVE_DOUBLE, Id(H5Screate(H5S_SCALAR), H5Sclose));
  if (H5Awrite(id, H5T_NATIVE_DOUBLE, &number) < 0)
    fail("{}: cannot write the attribute '{}'", path().string(), name);
}

void Hdf5File::set_attribute(std::string_view name, const std::vector<double>& numbers) {
  const Lock lock;
  const Id id = handle_->new_attribute(name, H5T_NATIVE_DOUBLE, simple_space({numbers.size()}));
  if (H5Awrite(id, H5T_NATIVE_DOUBLE, numbers.data()) < 0) {
    fail("{}: cannot write the attribute '{}'", path().string(), name);
  }
}

void Hdf5File::flush() {
  const Lock lock;
  if (H5Fflush(handle_->file, H5F_SCOPE_GLOBAL) < 0)
    fail("{}: cannot be written; is the disk full?", path().string());
}

void Hdf5File::close() {
  const Lock lock;
  if (handle_->file < 0) return;
  flush();
  if (H5Fclose(std::exchange(handle_->file, H5I_INVALID_HID)) < 0) {
    fail("{}: cannot be written; is the disk full?", path().string());
  }
}

int Hdf5File::require_format(std::string_view format, int newest_version) const {
  if (!has_attribute("format") || !has_attribute("version")) {
    fail("{}: no {} file: its attributes 'format' and 'version' are missing", path().string(), format);
  }
  const std::string found = text_attribute("format");
  if (found != format) fail("{}: expected a {} file, found a {} file", path().string(), format, found);
  const double version = number_attribute("version");
  if (!(version >= 1 && version <= newest_version)) {
    fail("{}: {} version {} is not known; this program reads up to version {}", path().string(), format,
         version, newest_version);
  }
  return static_cast<int>(version);
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
