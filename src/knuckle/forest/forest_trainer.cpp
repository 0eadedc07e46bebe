// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/forest_trainer.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/forest/most_that_fit.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/scoring_targets.h"
#include "knuckle/forest/split_score.h"

namespace knuckle {

namespace {

using Tree = GrownTree<PixelPair>;
using Parts = RegressionForest::Parts;

constexpr int kMostScoringDimensions = 95;
constexpr int kExactBits = 32;
constexpr double kGigabyte = 1e9;
/// Samples in a thread's working memory for small nodes.
constexpr double kSmallNodes = 2048.0;

/// The mean of the targets of all samples that reach each leaf: one row per leaf, in the order of the nodes.
std::vector<float> leaf_means(const TrainingSamples& samples, const Tree& tree,
                              const std::vector<std::size_t>& leaves) {
  const auto targets = static_cast<std::size_t>(samples.target_count());
  std::vector<float> means(leaves.size() * targets);
  parallel_for(std::ssize(leaves), [&](std::int64_t leaf) {
    const auto row = static_cast<std::size_t>(leaf);
    const std::span<const std::uint32_t> reached = tree.samples_of(tree.nodes[leaves[row]]);
    std::vector<double> sum(targets, 0.0);
    for (const std::uint32_t sample : reached) {
      const std::span<const float> values = samples.targets(sample);
      for (std::size_t d = 0; d < targets; ++d) sum[d] += values[d];
    }
    for (std::size_t d = 0; d < targets; ++d) {
      means[row * targets + d] = static_cast<float>(sum[d] / static_cast<double>(reached.size()));
    }
  });
  return means;
}

/// Adds a tree after those there are; leaves stay exact until the forest is whole.
void append_tree(Parts& parts, const TrainingSamples& samples, const Tree& tree) {
  const std::vector<std::size_t> leaves = append_nodes(parts.trees, tree, parts.leaves.leaf_count());
  std::vector<float> means = parts.leaves.decoded();
  const std::vector<float> added = leaf_means(samples, tree, leaves);
  means.insert(means.end(), added.begin(), added.end());
  parts.leaves = LeafTable(samples.target_count(), means, kExactBits);
}

/// All that the trees depend on, as text.
std::string fingerprint_of(RegressionForestOptions options, std::span<const double> target_weights,
                           std::uint64_t samples_hash) {
  options.leaf_bits = kExactBits;  // neither this nor the memory changes a tree
  options.memory_gb = RegressionForestOptions{}.memory_gb;
  std::string text = options_as_toml(options);
  for (const double weight : target_weights) text += fmt::format("weight {}\n", weight);
  return text + fmt::format("samples {:016x}\n", samples_hash);
}

}  // namespace

void RegressionForestOptions::visit(OptionVisitor& visitor) {
  visitor.integer("trees", trees, closed(1, 1000));
  tree.visit(visitor);
  visitor.integer("scoring_dimensions", scoring_dimensions, closed(1, kMostScoringDimensions));
  visitor.integer("leaf_bits", leaf_bits, closed(8, 32));
  visitor.real("memory_gb", memory_gb, open_closed(0, 1e6));
}

double training_memory(std::int64_t samples, int features, int targets,
                       const RegressionForestOptions& options) {
  const auto count = static_cast<double>(samples);
  const double feature_bytes = 2.0 * features;
  const double target_bytes = 4.0 * targets;
  const double scoring_bytes = 6.0 * std::min(targets, options.scoring_dimensions);  // float, then 16 bits
  const double order_bytes = 24.0;                                                   // hashes and indices
  const double node_samples =
      std::min(count, double(options.tree.samples_per_node)) + kSmallNodes * thread_count();
  const double leaves = options.trees * (count / options.tree.min_leaf_samples + 1.0);
  return count * (feature_bytes + target_bytes + scoring_bytes + order_bytes) + node_samples * feature_bytes +
         leaves * 2.0 * target_bytes;
}

void check_training_memory(std::int64_t samples, int features, int targets,
                           const RegressionForestOptions& options) {
  const double needed = training_memory(samples, features, targets, options) / kGigabyte;
  if (needed <= options.memory_gb) return;
  const auto fits = [&](std::int64_t count) {
    return training_memory(count, features, targets, options) <= options.memory_gb * kGigabyte;
  };
  fail(
      "forest training: {} samples of {} features take {:.3g} GB, memory_gb is {:.3g}; at most {} samples "
      "would fit",
      samples, features, needed, options.memory_gb, most_that_fit(samples, fits));
}

RegressionForest train_regression_forest(const TrainingSamples& samples,
                                         const RegressionForestOptions& options, const TrainingRun& run,
                                         std::span<const double> target_weights) {
  check_options(options, "forest training");
  if (options.leaf_bits != 8 && options.leaf_bits != 16 && options.leaf_bits != 32) {
    fail("forest training: leaf_bits is {}, expected 8, 16 or 32", options.leaf_bits);
  }
  if (samples.set_count() == 0) fail("forest training: there are no samples");
  check_training_memory(samples.capacity(), samples.feature_count(), samples.target_count(), options);
  const TrainingSamples::CanonicalOrder order = samples.canonical_order();
  const ScoringTargets scoring =
      make_scoring_targets(samples, order.indices, target_weights, options.scoring_dimensions);

  const std::string fingerprint = fingerprint_of(options, target_weights, order.hash);
  Parts parts;
  if (const auto file = open_checkpoint(run.checkpoint, fingerprint)) parts = read_forest(*file).parts();
  parts.feature_count = samples.feature_count();
  parts.quantizer = samples.quantizer();
  const auto append = [&](const Tree& tree) {
    append_tree(parts, samples, tree);
    if (run.checkpoint.empty()) return;
    write_checkpoint(run.checkpoint, fingerprint, [&](ModelWriter& file) {
      write_forest(file, RegressionForest(parts, run.checkpoint.string()));
    });
  };
  const PixelPairFeatures features(samples);
  const auto grow = [&]<int kLanes>() {
    grow_trees(features, VarianceStatistics<kLanes>(scoring), options.tree, order.indices,
               parts.trees.roots.size(), static_cast<std::size_t>(options.trees), run, fingerprint, append);
  };
  if (scoring.dimensions <= 7) {
    grow.template operator()<8>();
  } else if (scoring.dimensions <= 15) {
    grow.template operator()<16>();
  } else if (scoring.dimensions <= 31) {
    grow.template operator()<32>();
  } else if (scoring.dimensions <= 63) {
    grow.template operator()<64>();
  } else {
    grow.template operator()<96>();
  }
  remove_checkpoint(run.checkpoint);
  return RegressionForest(std::move(parts), "forest training").with_leaf_bits(options.leaf_bits);
}

}  // namespace knuckle
