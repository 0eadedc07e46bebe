// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/regression_forest.h"

#include <cmath>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/forest/pruning.h"

namespace knuckle {

namespace {

using PatchNode = RegressionForest::Node;

void check_parts(const RegressionForest::Parts& parts, const std::string& origin) {
  if (parts.feature_count < 1) fail("{}: a forest on {} features", origin, parts.feature_count);
  if (!(parts.quantizer.step > 0.0F && std::isfinite(parts.quantizer.step))) {
    fail("{}: the step of the features is {}, expected a number above 0", origin, parts.quantizer.step);
  }
  if (parts.leaves.dimensions() < 1) fail("{}: the forest predicts nothing", origin);
  check_trees(parts.trees, parts.leaves.leaf_count(), origin);
  for (std::size_t i = 0; i < parts.trees.nodes.size(); ++i) {
    const PixelPair& pair = parts.trees.nodes[i].feature;
    if (pair.first >= parts.feature_count || pair.second >= parts.feature_count) {
      fail("{}: node {} reads a feature beyond the {} there are", origin, i, parts.feature_count);
    }
  }
}

}  // namespace

RegressionForest::RegressionForest(Parts parts, const std::string& origin) : parts_(std::move(parts)) {
  check_parts(parts_, origin);
}

std::vector<std::uint32_t> RegressionForest::leaves_of(std::span<const float> features) const {
  if (std::ssize(features) != parts_.feature_count) {
    fail("regression forest: {} features, expected {}", features.size(), parts_.feature_count);
  }
  const PatchNode* const nodes = parts_.trees.nodes.data();
  const FeatureQuantizer quantized = parts_.quantizer;
  std::vector<std::uint32_t> leaves;
  leaves.reserve(parts_.trees.roots.size());
  for (const std::uint32_t root : parts_.trees.roots) {
    const PatchNode* node = nodes + root;
    while (node->next >= 0) {
      const int difference =
          quantized(features[node->feature.first]) - quantized(features[node->feature.second]);
      node = nodes + node->next + (difference >= node->threshold ? 1 : 0);
    }
    leaves.push_back(static_cast<std::uint32_t>(~node->next));
  }
  return leaves;
}

RegressionForest::Prediction RegressionForest::predict(std::span<const float> features) const {
  const auto targets = static_cast<std::size_t>(target_count());
  std::vector<double> sum(targets, 0.0);
  std::vector<double> squares(targets, 0.0);
  std::vector<float> row(targets);
  for (const std::uint32_t leaf : leaves_of(features)) {
    parts_.leaves.decode(leaf, row);
    for (std::size_t d = 0; d < targets; ++d) {
      sum[d] += row[d];
      squares[d] += double{row[d]} * row[d];
    }
  }
  const double trees = tree_count();
  Prediction prediction{std::vector<float>(targets), std::vector<float>(targets)};
  for (std::size_t d = 0; d < targets; ++d) {
    const double mean = sum[d] / trees;
    prediction.mean[d] = static_cast<float>(mean);
    prediction.deviation[d] = static_cast<float>(std::sqrt(std::max(0.0, squares[d] / trees - mean * mean)));
  }
  return prediction;
}

RegressionForest RegressionForest::with_leaf_bits(int bits) const {
  Parts parts = parts_;
  parts.leaves = LeafTable(target_count(), parts_.leaves.decoded(), bits);
  return {std::move(parts), "regression forest"};
}

RegressionForest RegressionForest::pruned(std::size_t most_leaves, std::span<const float> scale) const {
  const auto targets = static_cast<std::size_t>(target_count());
  if (scale.size() != targets) fail("pruning: {} scales for {} targets", scale.size(), targets);
  auto pruned = pruned_trees(parts_.trees, {targets, parts_.leaves.decoded()}, scale, most_leaves);
  Parts parts = parts_;
  parts.trees = std::move(pruned.trees);
  parts.leaves = LeafTable(target_count(), pruned.leaves.values, parts_.leaves.bits());
  return {std::move(parts), "regression forest"};
}

}  // namespace knuckle
