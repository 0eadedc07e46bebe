// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pixel_forest_trainer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/forest/class_statistics.h"
#include "knuckle/forest/most_that_fit.h"
#include "knuckle/forest/offset_features.h"

namespace knuckle {

namespace {

using Tree = GrownTree<OffsetPair>;

constexpr double kGigabyte = 1e9;
/// Samples in a thread's working memory for small nodes.
constexpr double kSmallNodes = 2048.0;

/// The part of class 1 among the samples that reach a leaf, as a code, rounded.
std::uint8_t leaf_code(const Tree& tree, std::size_t leaf, std::span<const std::uint8_t> labels) {
  const std::span<const std::uint32_t> reached = tree.samples_of(tree.nodes[leaf]);
  std::size_t ones = 0;
  for (const std::uint32_t sample : reached) ones += labels[sample];
  const std::size_t all = reached.size();
  return static_cast<std::uint8_t>((ones * PixelForest::kMostCode + all / 2) / all);
}

void append_tree(PixelForest::Parts& parts, const Tree& tree, std::span<const std::uint8_t> labels) {
  for (const std::size_t leaf : append_nodes(parts.trees, tree, parts.leaf_codes.size())) {
    parts.leaf_codes.push_back(leaf_code(tree, leaf, labels));
  }
}

/// All that the trees depend on, as text.
std::string fingerprint_of(PixelForestOptions options, std::uint64_t samples_hash) {
  options.memory_gb = PixelForestOptions{}.memory_gb;  // changes no tree
  return options_as_toml(options) + fmt::format("pixels {:016x}\n", samples_hash);
}

void check(const PixelForestOptions& options) {
  check_options(options, "forest training");
  if (options.offsets.nearest_offset_mm > options.offsets.farthest_offset_mm) {
    fail(
        "forest training: nearest_offset_mm is {} and farthest_offset_mm {}, expected the nearest to be "
        "smaller",
        options.offsets.nearest_offset_mm, options.offsets.farthest_offset_mm);
  }
}

}  // namespace

void PixelForestOptions::visit(OptionVisitor& visitor) {
  visitor.integer("trees", trees, closed(1, 250));
  tree.visit(visitor);
  offsets.visit(visitor);
  visitor.real("memory_gb", memory_gb, open_closed(0, 1e6));
}

double training_memory(std::int64_t samples, const PixelForestOptions& options) {
  const double count = static_cast<double>(samples);
  const double sample_bytes = sizeof(ArrangedSamples::Sample) + 1.0 + 2.0 * sizeof(std::uint32_t);
  const double node_samples =
      std::min(count, double(options.tree.samples_per_node)) + kSmallNodes * thread_count();
  const double node_bytes =
      sizeof(GrownNode<OffsetPair>) + sizeof(NodeSplit<OffsetPair>) + 2.0 * sizeof(PixelForest::Node);
  const double nodes = 2.0 * (count / options.tree.min_leaf_samples + 1.0);
  return count * sample_bytes + node_samples * 2.0 * options.offsets.offsets_per_node + nodes * node_bytes;
}

void check_training_memory(double image_bytes, std::int64_t images, std::int64_t samples,
                           const PixelForestOptions& options) {
  const double needed = image_bytes + training_memory(samples, options);
  const double allowed = options.memory_gb * kGigabyte;
  if (needed <= allowed) return;
  const auto fits = [&](std::int64_t count) {
    const double share = static_cast<double>(count) / static_cast<double>(images);
    const auto drawn = static_cast<std::int64_t>(std::ceil(share * static_cast<double>(samples)));
    return share * image_bytes + training_memory(drawn, options) <= allowed;
  };
  fail(
      "forest training: {} images with {} samples take {:.3g} GB, memory_gb is {:.3g}; at most {} images "
      "would fit",
      images, samples, needed / kGigabyte, options.memory_gb, most_that_fit(images, fits));
}

PixelForest train_pixel_forest(const PixelSamples& samples, const PixelForestOptions& options,
                               const TrainingRun& run) {
  check(options);
  const ArrangedSamples all = arranged(samples);
  if (all.samples.empty()) fail("forest training: there are no samples");
  const auto ones = std::accumulate(all.labels.begin(), all.labels.end(), std::size_t{0});
  if (ones == 0 || ones == all.labels.size()) {
    fail("forest training: all {} samples are of class {}, expected both classes", all.labels.size(),
         ones == 0 ? 0 : 1);
  }
  check_training_memory(static_cast<double>(samples.bytes()), std::ssize(samples.images()),
                        std::ssize(all.samples), options);

  const std::string fingerprint = fingerprint_of(options, all.hash);
  PixelForest::Parts parts;
  if (const auto file = open_checkpoint(run.checkpoint, fingerprint))
    parts = read_pixel_forest(*file).parts();
  const auto append = [&](const Tree& tree) {
    append_tree(parts, tree, all.labels);
    if (run.checkpoint.empty()) return;
    write_checkpoint(run.checkpoint, fingerprint, [&](ModelWriter& file) {
      write_forest(file, PixelForest(parts, run.checkpoint.string()));
    });
  };
  std::vector<std::uint32_t> order(all.samples.size());
  std::iota(order.begin(), order.end(), 0U);
  const OffsetFeatures features(samples, all, options.offsets);
  const ClassStatistics statistics(all.labels);
  grow_trees(features, statistics, options.tree, order, parts.trees.roots.size(),
             static_cast<std::size_t>(options.trees), run, fingerprint, append);
  remove_checkpoint(run.checkpoint);
  return {std::move(parts), "forest training"};
}

}  // namespace knuckle
