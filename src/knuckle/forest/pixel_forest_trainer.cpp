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
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/class_statistics.h"
#include "knuckle/forest/most_that_fit.h"
#include "knuckle/forest/offset_features.h"
#include "knuckle/forest/sample_moves.h"
#include "knuckle/forest/shared_leaves.h"

namespace knuckle {

namespace {

using Tree = GrownTree<OffsetPair>;

constexpr double kGigabyte = 1e9;
/// Samples in a thread's working memory for small nodes.
constexpr double kSmallNodes = 2048.0;

/// The part of class 1 among the samples that reach a leaf, as a code, rounded.
std::uint8_t leaf_code(std::size_t ones, std::size_t all) {
  return static_cast<std::uint8_t>((ones * PixelForest::kMostCode + all / 2) / all);
}

std::uint8_t leaf_code(std::span<const std::uint32_t> reached, std::span<const std::uint8_t> labels) {
  std::size_t ones = 0;
  for (const std::uint32_t sample : reached) ones += labels[sample];
  return leaf_code(ones, reached.size());
}

void append_tree(PixelForest::Parts& parts, const Tree& tree, std::span<const std::uint8_t> labels) {
  for (const std::size_t leaf : append_nodes(parts.trees, tree, parts.leaf_codes.size())) {
    parts.leaf_codes.push_back(leaf_code(tree.samples_of(tree.nodes[leaf]), labels));
  }
}

/// Adds a tree of all workers; at worker 0 alone.
void append_tree(PixelForest::Parts& parts, WorkerGroup& workers, const SharedTree<OffsetPair>& tree,
                 std::span<const std::uint8_t> labels) {
  FlatTrees<OffsetPair> unused;
  const bool is_first = workers.rank() == 0;
  std::vector<SharedLeaf> leaves;
  for (const std::size_t node :
       append_nodes(is_first ? parts.trees : unused, tree.own, parts.leaf_codes.size())) {
    leaves.push_back({tree.own.samples_of(tree.own.nodes[node]), tree.shares[node]});
  }
  for (const auto& [ones, all] : shared_class_counts(workers, labels, leaves)) {
    parts.leaf_codes.push_back(leaf_code(static_cast<std::size_t>(ones), static_cast<std::size_t>(all)));
  }
}

/// Moves the images of all workers to where the order of training has them: by their hash, then their number.
/// Returns this worker's.
std::vector<std::uint32_t> images_in_order(WorkerGroup& workers, PixelSamples& samples,
                                           std::int64_t first_number, const PixelForestOptions& options) {
  const std::vector<std::uint64_t> hashes = hashes_of_images(samples);
  std::vector<std::uint32_t> own;
  std::vector<SampleKey> keys;
  for (std::uint32_t i = 0; i < hashes.size(); ++i) {
    if (samples.images()[i].pixels.empty()) continue;
    own.push_back(i);
    keys.push_back({hashes[i], first_number + i});
  }
  const CanonicalPlaces canonical = canonical_places(workers, keys);
  const std::int64_t part = part_of_worker(canonical.total, workers.rank(), workers.size()).size();
  check_training_memory(static_cast<double>(part) * sizeof(PixelSamples::DepthImage), part, part, options);
  return moved_to_places(workers, samples, own, canonical.places,
                         equal_cuts(canonical.total, workers.size()));
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

void check_classes(std::int64_t ones, std::int64_t all) {
  if (all == 0) fail("forest training: there are no samples");
  if (ones == 0 || ones == all) {
    fail("forest training: all {} samples are of class {}, expected both classes", all, ones == 0 ? 0 : 1);
  }
}

PixelForest::Parts first_parts(const std::filesystem::path& checkpoint, const std::string& fingerprint) {
  if (const auto file = open_checkpoint(checkpoint, fingerprint)) return read_pixel_forest(*file).parts();
  return {};
}

void write_parts(const std::filesystem::path& checkpoint, const std::string& fingerprint,
                 const PixelForest::Parts& parts) {
  if (checkpoint.empty()) return;
  write_checkpoint(checkpoint, fingerprint,
                   [&](ModelWriter& file) { write_forest(file, PixelForest(parts, checkpoint.string())); });
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
  check_classes(std::accumulate(all.labels.begin(), all.labels.end(), std::int64_t{0}),
                std::ssize(all.labels));
  check_training_memory(static_cast<double>(samples.bytes()), std::ssize(samples.images()),
                        std::ssize(all.samples), options);

  const std::string fingerprint = fingerprint_of(options, all.hash);
  PixelForest::Parts parts = first_parts(run.checkpoint, fingerprint);
  const auto append = [&](const Tree& tree) {
    append_tree(parts, tree, all.labels);
    write_parts(run.checkpoint, fingerprint, parts);
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

std::optional<PixelForest> train_pixel_forest(WorkerGroup& workers, PixelSamples& samples,
                                              std::int64_t first_number, const PixelForestOptions& options,
                                              const TrainingRun& run) {
  check(options);
  const std::vector<std::uint32_t> images = images_in_order(workers, samples, first_number, options);
  const ArrangedPart part = arranged(samples, images, hashes_of_images(samples));
  const ArrangedSamples& own = part.samples;
  const std::string fingerprint = fingerprint_of(options, chained_hash(workers, part.words));
  OwnSamples order{.samples = std::vector<std::uint32_t>(own.samples.size()),
                   .count = sum_of_workers(workers, std::ssize(own.samples))};
  std::iota(order.samples.begin(), order.samples.end(), 0U);
  const auto ones = std::accumulate(own.labels.begin(), own.labels.end(), std::int64_t{0});
  check_classes(sum_of_workers(workers, ones).total, order.count.total);
  // Where what all have does not fit on average, it does not fit somewhere.
  const std::int64_t average = order.count.total / workers.size();
  check_training_memory(static_cast<double>(samples.bytes()), std::ssize(samples.images()),
                        std::max(std::ssize(own.samples), average), options);

  PixelForest::Parts parts = first_parts(run.checkpoint, fingerprint);
  const auto append = [&](const SharedTree<OffsetPair>& tree) {
    append_tree(parts, workers, tree, own.labels);
    write_parts(run.checkpoint, fingerprint, parts);
  };
  const std::size_t first_tree = values_of_all(workers, parts.trees.roots.size())[0];
  const OffsetFeatures features(samples, own, options.offsets);
  const ClassStatistics statistics(own.labels);
  grow_shared_trees(
      workers, features, statistics, options.tree, [&] { return order; }, {}, first_tree,
      static_cast<std::size_t>(options.trees), run, fingerprint, append);
  remove_checkpoint(run.checkpoint);
  if (workers.rank() != 0) return std::nullopt;
  return PixelForest(std::move(parts), "forest training");
}

}  // namespace knuckle
