// SPDX-License-Identifier: Apache-2.0
// Attributes of a file's root.
#include <algorithm>
#include <string>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/storage/hdf5/hdf5_handle.h"

namespace knuckle {
namespace {

/// HDF5 holds no longer ones without another kind of storage: such a text is an array of bytes.
constexpr std::size_t kLongestAttribute = 60000;

}  // namespace

bool Hdf5File::has_attribute(std::string_view name) const {
  const Hdf5Lock lock;
  return H5Aexists(handle_->file, std::string(name).c_str()) > 0;
}

std::string Hdf5File::text_attribute(std::string_view name) const {
  const Hdf5Lock lock;
  if (!has_attribute(name) && has(name)) {
    const std::vector<std::uint8_t> bytes = read<std::uint8_t>(name).values;
    return {bytes.begin(), bytes.end()};
  }
  const Hdf5Id id = handle_->attribute(name);
  const Hdf5Id file_type(H5Aget_type(id), H5Tclose);
  if (H5Tget_class(file_type) != H5T_STRING)
    fail("{}: the attribute '{}' is not text", path().string(), name);
  if (H5Tis_variable_str(file_type) != 0) {
    fail(
        "{}: the attribute '{}' is a text of variable length, as Knuckle 0.1 wrote it; expected one of fixed "
        "length: write the file again, or change it with scripts/convert_h5_texts.py",
        path().string(), name);
  }
  handle_->require_one_value(name, id);
  handle_->check_attribute_size(name, H5Tget_size(file_type));
  if (H5Tget_size(file_type) > static_cast<std::size_t>(limits::kDocumentBytes)) {
    fail("{}: the attribute '{}' is a text of {} bytes, expected at most {}", path().string(), name,
         H5Tget_size(file_type), limits::kDocumentBytes);
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
  const Hdf5Lock lock;
  const Hdf5Id id = handle_->attribute(name);
  const Hdf5Id type(H5Aget_type(id), H5Tclose);
  if (H5Tget_class(type) != H5T_INTEGER && H5Tget_class(type) != H5T_FLOAT) {
    fail("{}: the attribute '{}' is not a number", path().string(), name);
  }
  const Hdf5Id space(H5Aget_space(id), H5Sclose);
  const auto count = static_cast<std::size_t>(std::max<hssize_t>(0, H5Sget_simple_extent_npoints(space)));
  constexpr std::size_t kMostNumbers = 4096;
  if (count > kMostNumbers) {
    fail("{}: the attribute '{}' holds {} numbers, expected at most {}", path().string(), name, count,
         kMostNumbers);
  }
  std::vector<double> numbers(count);
  if (H5Aread(id, H5T_NATIVE_DOUBLE, numbers.data()) < 0) {
    fail("{}: the attribute '{}' cannot be read", path().string(), name);
  }
  return numbers;
}

void Hdf5File::set_attribute(std::string_view name, std::string_view text) {
  const Hdf5Lock lock;
  if (text.size() > kLongestAttribute) {
    write(name, {text.size()}, reinterpret_cast<const std::uint8_t*>(text.data()));
    return;
  }
  const std::string owned(text);
  const Hdf5Id type = text_type(owned.size());
  const Hdf5Id id = handle_->new_attribute(name, type, Hdf5Id(H5Screate(H5S_SCALAR), H5Sclose));
  if (H5Awrite(id, type, owned.c_str()) < 0)
    fail("{}: cannot write the attribute '{}'", path().string(), name);
}

void Hdf5File::set_attribute(std::string_view name, double number) {
  const Hdf5Lock lock;
  const Hdf5Id id = handle_->new_attribute(name, H5T_NATIVE_DOUBLE, Hdf5Id(H5Screate(H5S_SCALAR), H5Sclose));
  if (H5Awrite(id, H5T_NATIVE_DOUBLE, &number) < 0)
    fail("{}: cannot write the attribute '{}'", path().string(), name);
}

void Hdf5File::set_attribute(std::string_view name, const std::vector<double>& numbers) {
  const Hdf5Lock lock;
  const Hdf5Id id = handle_->new_attribute(name, H5T_NATIVE_DOUBLE, simple_space({numbers.size()}));
  if (H5Awrite(id, H5T_NATIVE_DOUBLE, numbers.data()) < 0) {
    fail("{}: cannot write the attribute '{}'", path().string(), name);
  }
}

}  // namespace knuckle
