// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/hdf5/hdf5_attributes.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace knuckle {
namespace {

/// Parts of attributes of version 1 fill up eight bytes.
std::uint64_t padded(std::uint64_t bytes, int version) {
  return version == 1 ? (bytes + 7) / 8 * 8 : bytes;
}

std::pair<std::string, Hdf5Attribute> read_attribute(Hdf5Cursor cursor) {
  const int version = cursor.u8();
  if (version < 1 || version > 3) cursor.file().damaged("an attribute is of an unknown version");
  const unsigned flags = cursor.u8();
  const std::uint64_t name_bytes = cursor.u16();
  const std::uint64_t type_bytes = cursor.u16();
  const std::uint64_t shape_bytes = cursor.u16();
  if (version == 3) cursor.skip(1);  // character set
  const std::span<const std::uint8_t> name = cursor.take(padded(name_bytes, version));
  std::string text(name.begin(), std::find(name.begin(), name.end(), 0));
  Hdf5Attribute attribute;
  const std::span<const std::uint8_t> type = cursor.take(padded(type_bytes, version));
  const std::span<const std::uint8_t> shape = cursor.take(padded(shape_bytes, version));
  const bool has_own_type_and_shape = version == 1 || (flags & 0x03U) == 0;
  if (!has_own_type_and_shape) return {std::move(text), std::move(attribute)};  // of another kind
  attribute.type = read_type(Hdf5Cursor(type, cursor.file()));
  attribute.shape = read_shape(Hdf5Cursor(shape, cursor.file()));
  const std::span<const std::uint8_t> values = cursor.take(cursor.left());
  const std::uint64_t bytes = saturated_product(value_count(attribute.shape), attribute.type.bytes);
  if (bytes > values.size()) {
    cursor.file().damaged(
        fmt::format("the attribute '{}' declares {} bytes and has {}", text, bytes, values.size()));
  }
  attribute.values.assign(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(bytes));
  return {std::move(text), std::move(attribute)};
}

void refuse_attributes_outside_header(const Hdf5Bytes& file, const Hdf5Message& message) {
  Hdf5Cursor cursor(message.bytes, file);
  cursor.skip(1);
  if ((cursor.u8() & 0x01U) != 0) cursor.skip(2);
  if (cursor.address()) file.too_new("attributes outside of a header");
}

}  // namespace

std::vector<std::uint64_t> read_shape(Hdf5Cursor cursor) {
  const int version = cursor.u8();
  const std::size_t rank = cursor.u8();
  cursor.skip(1);  // whether it may grow
  if (version == 1) {
    cursor.skip(5);
  } else if (version == 2) {
    constexpr unsigned kWithoutValues = 2;
    if (cursor.u8() == kWithoutValues) return {0};
  } else {
    cursor.file().damaged("a shape is of an unknown version");
  }
  constexpr std::size_t kMostDimensions = 32;
  if (rank > kMostDimensions) cursor.file().damaged("a shape has too many dimensions");
  std::vector<std::uint64_t> shape(rank);
  for (std::uint64_t& side : shape) side = cursor.length();
  return shape;
}

std::uint64_t saturated_product(std::uint64_t a, std::uint64_t b) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  return b != 0 && a > kLargest / b ? kLargest : a * b;
}

std::uint64_t value_count(const std::vector<std::uint64_t>& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::uint64_t{1}, saturated_product);
}

Hdf5Attributes read_attributes(const Hdf5Bytes& file, const std::vector<Hdf5Message>& messages) {
  Hdf5Attributes attributes;
  for (const Hdf5Message& message : messages) {
    if (message.type == Hdf5MessageType::attribute_info) refuse_attributes_outside_header(file, message);
    if (message.type != Hdf5MessageType::attribute) continue;
    if (message.is_shared) file.too_new("a shared attribute");
    attributes.insert(read_attribute(Hdf5Cursor(message.bytes, file)));
  }
  return attributes;
}

}  // namespace knuckle
