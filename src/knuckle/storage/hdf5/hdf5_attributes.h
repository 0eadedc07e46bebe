// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/storage/hdf5/hdf5_number.h"
#include "knuckle/storage/hdf5/hdf5_object.h"

namespace knuckle {

/// The shape of a dataspace message, slowest dimension first; none for a single value. Of a space without
/// values the shape is {0}.
std::vector<std::uint64_t> read_shape(Hdf5Cursor cursor);

/// The product, or the largest number where it is more.
std::uint64_t saturated_product(std::uint64_t a, std::uint64_t b);
/// The same of all sides of a shape.
std::uint64_t value_count(const std::vector<std::uint64_t>& shape);

/// A small value beside the arrays.
struct Hdf5Attribute {
  Hdf5Type type;
  std::vector<std::uint64_t> shape;
  std::vector<std::uint8_t> values;
};
using Hdf5Attributes = std::map<std::string, Hdf5Attribute, std::less<>>;

/// All attributes in an object's header; throws where there are others elsewhere.
Hdf5Attributes read_attributes(const Hdf5Bytes& file, const std::vector<Hdf5Message>& messages);

}  // namespace knuckle
