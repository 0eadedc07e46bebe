// SPDX-License-Identifier: Apache-2.0
// The arrays of a forest in HDF5.
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/forest/leaf_coding.h"
#include "knuckle/forest/regression_forest.h"

namespace knuckle {

namespace {

constexpr std::uint64_t kLeavesPerChunk = 1 << 10;

template <class Code>
LeafTable::Codes read_codes(const Hdf5File& file, std::size_t columns) {
  Hdf5Array<Code> array = file.read<Code>("leaf_value");
  if (array.values.size() % columns != 0 || (array.shape.size() == 2 && array.shape[1] != columns)) {
    fail("{}: leaf_value has no rows of {} values", file.path().string(), columns);
  }
  return std::move(array.values);
}

constexpr std::string_view kComponents = "leaf_component";
constexpr int kCodedLeafBits = 8;

LeafTable read_coded_leaves(const Hdf5File& file) {
  CodedLeaves coded;
  coded.step = static_cast<float>(file.number_attribute("leaf_code_step"));
  coded.scale = file.read<float>("leaf_scale").values;
  coded.mean = file.read<float>("leaf_mean").values;
  coded.components = file.read<float>(kComponents).values;
  coded.codes = file.read<std::uint16_t>("leaf_code").values;
  const std::vector<float> values = decoded(coded, file.path().string());
  return {static_cast<int>(coded.mean.size()), values, kCodedLeafBits};
}

}  // namespace

LeafTable read_leaves(const Hdf5File& file) {
  if (file.has(kComponents)) return read_coded_leaves(file);
  const std::vector<float> offset = file.read<float>("leaf_offset").values;
  const std::vector<float> step = file.read<float>("leaf_step").values;
  const std::string origin = file.path().string();
  if (offset.empty()) fail("{}: leaf_offset is empty, expected a value per target", origin);
  const auto bits = static_cast<int>(file.number_attribute("leaf_bits"));
  switch (bits) {
    case 8:
      return {offset, step, read_codes<std::uint8_t>(file, offset.size()), origin};
    case 16:
      return {offset, step, read_codes<std::uint16_t>(file, offset.size()), origin};
    case 32:
      return {offset, step, read_codes<float>(file, offset.size()), origin};
    default:
      fail("{}: leaf_bits is {}, expected 8, 16 or 32", origin, bits);
  }
}

void write_leaves(Hdf5File& file, const LeafTable& leaves) {
  file.set_attribute("leaf_bits", leaves.bits());
  const auto columns = static_cast<std::uint64_t>(leaves.dimensions());
  file.write("leaf_offset", {columns}, leaves.offset().data());
  file.write("leaf_step", {columns}, leaves.step().data());
  std::visit(
      [&](const auto& codes) { detail::write_rows(file, "leaf_value", codes, columns, kLeavesPerChunk); },
      leaves.codes());
}

void write_leaves(Hdf5File& file, const LeafTable& leaves, const LeafCoding& coding) {
  const CodedLeaves codes = coded(leaves, coding);
  const std::uint64_t dimensions = codes.mean.size();
  file.set_attribute("leaf_code_step", codes.step);
  file.write("leaf_scale", {dimensions}, codes.scale.data());
  file.write("leaf_mean", {dimensions}, codes.mean.data());
  file.write(kComponents, {dimensions, dimensions}, codes.components.data());
  constexpr std::uint64_t kOneComponent = 1;
  file.write("leaf_code", {dimensions, leaves.leaf_count()}, codes.codes.data(),
             {kOneComponent, detail::kForestDeflateLevel});
}

void write_forest(Hdf5File& file, const RegressionForest& forest, const std::optional<LeafCoding>& coding) {
  const RegressionForest::Parts& parts = forest.parts();
  file.set_attribute("feature_count", parts.feature_count);
  file.set_attribute("feature_step", parts.quantizer.step);
  write_trees(file, parts.trees);
  if (coding) {
    write_leaves(file, parts.leaves, *coding);
  } else {
    write_leaves(file, parts.leaves);
  }
}

RegressionForest read_forest(const Hdf5File& file) {
  RegressionForest::Parts parts;
  parts.feature_count = static_cast<int>(file.number_attribute("feature_count"));
  parts.quantizer.step = static_cast<float>(file.number_attribute("feature_step"));
  parts.trees = read_trees<PixelPair>(file);
  parts.leaves = read_leaves(file);
  return {std::move(parts), file.path().string()};
}

}  // namespace knuckle
