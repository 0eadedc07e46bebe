// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_file.h"

#include "knuckle/core/error.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/storage/hdf5/hdf5_handle.h"

namespace knuckle {

Hdf5File::Hdf5File(std::unique_ptr<Handle> handle) : handle_(std::move(handle)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

namespace {

hid_t open_with(const std::filesystem::path& path, unsigned mode) {
  if (!std::filesystem::exists(path)) fail("{}: the file is missing", path.string());
  require_regular_file(path);
  if (H5Fis_hdf5(path.c_str()) <= 0) fail("{}: no HDF5 file, or its beginning is damaged", path.string());
  const hid_t file = H5Fopen(path.c_str(), mode, H5P_DEFAULT);
  if (file < 0) fail("{}: the HDF5 file is cut short, damaged, or in use", path.string());
  return file;
}

}  // namespace

Hdf5File Hdf5File::open(const std::filesystem::path& path) {
  const Hdf5Lock lock;
  return Hdf5File(std::make_unique<Handle>(path, open_with(path, H5F_ACC_RDONLY)));
}

Hdf5File Hdf5File::open_for_writing(const std::filesystem::path& path) {
  const Hdf5Lock lock;
  return Hdf5File(std::make_unique<Handle>(path, open_with(path, H5F_ACC_RDWR)));
}

Hdf5File Hdf5File::create(const std::filesystem::path& path) {
  const Hdf5Lock lock;
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (file < 0) fail("{}: cannot write the HDF5 file", path.string());
  return Hdf5File(std::make_unique<Handle>(path, file));
}

const std::filesystem::path& Hdf5File::path() const {
  return handle_->path;
}

void Hdf5File::flush() {
  const Hdf5Lock lock;
  if (H5Fflush(handle_->file, H5F_SCOPE_GLOBAL) < 0)
    fail("{}: cannot be written; is the disk full?", path().string());
}

void Hdf5File::close() {
  const Hdf5Lock lock;
  if (handle_->file < 0) return;
  flush();
  handle_->kept.clear();
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

}  // namespace knuckle
