// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_file.h"

#include <map>
#include <mutex>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/storage/hdf5/hdf5_attributes.h"
#include "knuckle/storage/hdf5/hdf5_dataset.h"

namespace knuckle {

struct Hdf5File::Content {
  Hdf5Bytes file;
  Hdf5Links links;
  Hdf5Attributes attributes;
  std::mutex mutex;                                          ///< of `datasets`
  std::map<std::string, Hdf5Dataset, std::less<>> datasets;  ///< that were asked for; what is in it stays

  explicit Content(const std::filesystem::path& path) : file(path) {
    const std::vector<Hdf5Message> root = read_object(file, file.root());
    links = read_links(file, root);
    attributes = read_attributes(file, root);
  }

  const Hdf5Dataset& dataset(std::string_view name) {
    const std::lock_guard lock(mutex);
    const auto known = datasets.find(name);
    if (known != datasets.end()) return known->second;
    const auto link = links.find(name);
    if (link == links.end()) fail("{}: {}: the array is missing", file.path().string(), name);
    if (!link->second)
      fail("{}: {}: is a link; expected the array itself, in this file", file.path().string(), name);
    Hdf5Dataset opened(file, std::string(name), *link->second);
    return datasets.emplace(name, std::move(opened)).first->second;
  }

  const Hdf5Attribute& attribute(std::string_view name) const {
    const auto found = attributes.find(name);
    if (found == attributes.end()) fail("{}: the attribute '{}' is missing", file.path().string(), name);
    return found->second;
  }
};

Hdf5File::Hdf5File(std::unique_ptr<Content> content) : content_(std::move(content)) {}
Hdf5File::Hdf5File(Hdf5File&&) noexcept = default;
Hdf5File& Hdf5File::operator=(Hdf5File&&) noexcept = default;
Hdf5File::~Hdf5File() = default;

Hdf5File Hdf5File::open(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) fail("{}: the file is missing", path.string());
  return Hdf5File(std::make_unique<Content>(path));
}

const std::filesystem::path& Hdf5File::path() const {
  return content_->file.path();
}

bool Hdf5File::has(std::string_view dataset) const {
  return content_->links.contains(dataset);
}

std::vector<std::uint64_t> Hdf5File::shape(std::string_view dataset) const {
  return content_->dataset(dataset).checked_shape();
}

template <class T>
Hdf5Array<T> Hdf5File::read(std::string_view dataset) const {
  const Hdf5Dataset& found = content_->dataset(dataset);
  Hdf5Array<T> array;
  array.shape = found.shape();
  array.values.resize(found.checked_count());
  if (array.shape.empty()) fail("{}: {}: expected an array, found a single number", path().string(), dataset);
  if (!array.values.empty()) found.read_rows(0, array.shape[0], array.values.data());
  return array;
}

template <class T>
void Hdf5File::read_rows(std::string_view dataset, std::uint64_t first, std::uint64_t count,
                         T* values) const {
  content_->dataset(dataset).read_rows(first, count, values);
}

bool Hdf5File::has_attribute(std::string_view name) const {
  return content_->attributes.contains(name);
}

std::string Hdf5File::text_attribute(std::string_view name) const {
  if (!has_attribute(name) && has(name)) {
    const std::vector<std::uint8_t> bytes = read<std::uint8_t>(name).values;
    return {bytes.begin(), bytes.end()};
  }
  const Hdf5Attribute& attribute = content_->attribute(name);
  if (attribute.type.kind == Hdf5Type::Kind::variable_text) {
    fail(
        "{}: the attribute '{}' is a text of variable length, as Knuckle 0.1 wrote it; expected one of fixed "
        "length: write the file again, or change it with scripts/convert_h5_texts.py",
        path().string(), name);
  }
  if (attribute.type.kind != Hdf5Type::Kind::text)
    fail("{}: the attribute '{}' is not text", path().string(), name);
  const std::uint64_t count = value_count(attribute.shape);
  if (count != 1) fail("{}: the attribute '{}' has {} values, expected 1", path().string(), name, count);
  const std::string text(attribute.values.begin(), attribute.values.end());
  return text.substr(0, text.find('\0'));
}

double Hdf5File::number_attribute(std::string_view name) const {
  const std::vector<double> numbers = numbers_attribute(name);
  if (numbers.size() != 1)
    fail("{}: the attribute '{}' holds {} numbers, expected 1", path().string(), name, numbers.size());
  return numbers[0];
}

std::vector<double> Hdf5File::numbers_attribute(std::string_view name) const {
  const Hdf5Attribute& attribute = content_->attribute(name);
  if (attribute.type.kind != Hdf5Type::Kind::number)
    fail("{}: the attribute '{}' is not a number", path().string(), name);
  std::vector<double> numbers(attribute.values.size() / attribute.type.number.bytes);
  convert_numbers(attribute.type.number, attribute.values, std::span(numbers));  // a double holds all of them
  return numbers;
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

#define KNUCKLE_INSTANTIATE(T)                                     \
  template Hdf5Array<T> Hdf5File::read<T>(std::string_view) const; \
  template void Hdf5File::read_rows(std::string_view, std::uint64_t, std::uint64_t, T*) const;
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
