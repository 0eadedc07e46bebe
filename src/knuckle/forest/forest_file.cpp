// SPDX-License-Identifier: Apache-2.0
// The arrays of a forest in a model's file.
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/forest/leaf_coding.h"
#include "knuckle/forest/regression_forest.h"

namespace knuckle {

namespace {

template <class Code>
LeafTable::Codes read_codes(const ModelFile& file, std::size_t columns) {
  const std::vector<std::uint64_t>& shape = file.shape("leaf_value");
  if (shape.size() != 2 || shape[1] != columns) {
    fail("{}: leaf_value does not have rows of {} values", file.origin(), columns);
  }
  return file.read<Code>("leaf_value").values;
}

constexpr std::string_view kComponents = "leaf_component";
constexpr int kCodedLeafBits = 8;

LeafTable read_coded_leaves(const ModelFile& file) {
  CodedLeaves coded;
  coded.step = static_cast<float>(file.number("leaf_code_step"));
  coded.scale = file.read<float>("leaf_scale").values;
  coded.mean = file.read<float>("leaf_mean").values;
  coded.components = file.read<float>(kComponents).values;
  coded.codes = file.read<std::uint16_t>("leaf_code").values;
  const std::vector<float> values = decoded(coded, file.origin());
  return {static_cast<int>(coded.mean.size()), values, kCodedLeafBits};
}

}  // namespace

LeafTable read_leaves(const ModelFile& file) {
  if (file.has(kComponents)) return read_coded_leaves(file);
  const std::vector<float> offset = file.read<float>("leaf_offset").values;
  const std::vector<float> step = file.read<float>("leaf_step").values;
  const std::string& origin = file.origin();
  if (offset.empty()) fail("{}: leaf_offset is empty, expected a value per target", origin);
  const int bits = file.integer("leaf_bits", 8, 32);
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

void write_leaves(ModelWriter& file, const LeafTable& leaves) {
  file.set("leaf_bits", leaves.bits());
  const auto columns = static_cast<std::uint64_t>(leaves.dimensions());
  file.add("leaf_offset", {columns}, leaves.offset());
  file.add("leaf_step", {columns}, leaves.step());
  std::visit(
      [&](const auto& codes) {
        file.add("leaf_value", {leaves.leaf_count(), columns}, codes);
      },
      leaves.codes());
}

void write_leaves(ModelWriter& file, const LeafTable& leaves, const LeafCoding& coding) {
  const CodedLeaves codes = coded(leaves, coding);
  const std::uint64_t dimensions = codes.mean.size();
  file.set("leaf_code_step", codes.step);
  file.add("leaf_scale", {dimensions}, codes.scale);
  file.add("leaf_mean", {dimensions}, codes.mean);
  file.add(kComponents, {dimensions, dimensions}, codes.components);
  file.add("leaf_code", {dimensions, leaves.leaf_count()}, codes.codes);
}

void write_forest(ModelWriter& file, const RegressionForest& forest,
                  const std::optional<LeafCoding>& coding) {
  const RegressionForest::Parts& parts = forest.parts();
  file.set("feature_count", parts.feature_count);
  file.set("feature_step", parts.quantizer.step);
  write_trees(file, parts.trees);
  if (coding) {
    write_leaves(file, parts.leaves, *coding);
  } else {
    write_leaves(file, parts.leaves);
  }
}

RegressionForest read_forest(const ModelFile& file) {
  RegressionForest::Parts parts;
  parts.feature_count = file.integer("feature_count", 1, limits::kForestFeatures);
  parts.quantizer.step = static_cast<float>(file.number("feature_step"));
  parts.trees = read_trees<PixelPair>(file);
  parts.leaves = read_leaves(file);
  return {std::move(parts), file.origin()};
}

}  // namespace knuckle
