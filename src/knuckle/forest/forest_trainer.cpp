// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/forest_trainer.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/worker_messages.h"
#include "knuckle/forest/most_that_fit.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/sample_moves.h"
#include "knuckle/forest/scoring_targets.h"
#include "knuckle/forest/shared_leaves.h"
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

/// Adds leaves after those there are; they stay exact until the forest is whole.
void append_leaves(Parts& parts, int targets, std::span<const float> added) {
  std::vector<float> means = parts.leaves.decoded();
  means.insert(means.end(), added.begin(), added.end());
  parts.leaves = LeafTable(targets, means, kExactBits);
}

/// Adds a tree after those there are.
void append_tree(Parts& parts, const TrainingSamples& samples, const Tree& tree) {
  const std::vector<std::size_t> leaves = append_nodes(parts.trees, tree, parts.leaves.leaf_count());
  append_leaves(parts, samples.target_count(), leaf_means(samples, tree, leaves));
}

/// Adds a tree of all workers; at worker 0 alone.
void append_tree(Parts& parts, WorkerGroup& workers, const TrainingSamples& samples,
                 const SharedTree<PixelPair>& tree) {
  FlatTrees<PixelPair> unused;
  const bool is_first = workers.rank() == 0;
  std::vector<SharedLeaf> leaves;
  for (const std::size_t node :
       append_nodes(is_first ? parts.trees : unused, tree.own, is_first ? parts.leaves.leaf_count() : 0)) {
    leaves.push_back({tree.own.samples_of(tree.own.nodes[node]), tree.shares[node]});
  }
  const std::vector<float> means = shared_leaf_means(workers, samples, leaves);
  if (is_first) append_leaves(parts, samples.target_count(), means);
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

void check(const RegressionForestOptions& options) {
  check_options(options, "forest training");
  if (options.leaf_bits != 8 && options.leaf_bits != 16 && options.leaf_bits != 32) {
    fail("forest training: leaf_bits is {}, expected 8, 16 or 32", options.leaf_bits);
  }
}

/// Calls `grow` with statistics that are large enough for the dimensions.
template <class Grow>
void with_statistics(const ScoringTargets& scoring, const Grow& grow) {
  if (scoring.dimensions <= 7) {
    grow(VarianceStatistics<8>(scoring));
  } else if (scoring.dimensions <= 15) {
    grow(VarianceStatistics<16>(scoring));
  } else if (scoring.dimensions <= 31) {
    grow(VarianceStatistics<32>(scoring));
  } else if (scoring.dimensions <= 63) {
    grow(VarianceStatistics<64>(scoring));
  } else {
    grow(VarianceStatistics<96>(scoring));
  }
}

/// The trees that a stopped training has left, and what new ones are like.
Parts first_parts(const TrainingSamples& samples, const std::filesystem::path& checkpoint,
                  const std::string& fingerprint) {
  Parts parts;
  if (const auto file = open_checkpoint(checkpoint, fingerprint)) parts = read_forest(*file).parts();
  parts.feature_count = samples.feature_count();
  parts.quantizer = samples.quantizer();
  return parts;
}

void write_parts(const std::filesystem::path& checkpoint, const std::string& fingerprint,
                 const Parts& parts) {
  if (checkpoint.empty()) return;
  write_checkpoint(checkpoint, fingerprint, [&](ModelWriter& file) {
    write_forest(file, RegressionForest(parts, checkpoint.string()));
  });
}

/// A worker's samples, with what goes with them where they move to another.
class MovingSamples {
 public:
  explicit MovingSamples(TrainingSamples& samples) : samples_(samples) {
    for (std::int64_t i = samples.capacity() - 1; i >= 0; --i) {
      if (!samples.is_set(i)) free_.push_back(static_cast<std::uint32_t>(i));
    }
    places_.resize(static_cast<std::size_t>(samples.capacity()));
  }

  std::size_t message_bytes(std::uint32_t slot) const {
    return samples_.message_bytes(slot) + sizeof(std::int64_t) + scoring_.dimensions * sizeof(std::int16_t);
  }
  void take(std::uint32_t slot, std::vector<std::byte>& message) {
    samples_.take(slot, message);
    append_value(message, places_[slot]);
    if (scoring_.dimensions > 0) append_values(message, std::span<const std::int16_t>(scoring_row(slot)));
    free_.push_back(slot);
  }
  std::uint32_t put(MessageReader& reader) {
    std::uint32_t slot = static_cast<std::uint32_t>(samples_.capacity());
    if (!free_.empty()) {
      slot = free_.back();
      free_.pop_back();
    } else {
      places_.push_back(0);
      scoring_.values.resize(scoring_.values.size() + static_cast<std::size_t>(scoring_.dimensions));
    }
    samples_.put(slot, reader);
    places_[slot] = reader.value<std::int64_t>();
    if (scoring_.dimensions > 0) reader.read(scoring_row(slot));
    return slot;
  }

  /// Sets the places in the canonical order of all samples of all workers.
  void set_places(WorkerGroup& workers, std::int64_t first_number) {
    const std::vector<std::uint32_t> slots = all_slots();
    std::vector<SampleKey> keys(slots.size());
    parallel_for(std::ssize(slots), [&](std::int64_t i) {
      const std::uint32_t slot = slots[static_cast<std::size_t>(i)];
      keys[static_cast<std::size_t>(i)] = {samples_.hash_of(slot), first_number + slot};
    });
    const CanonicalPlaces canonical = canonical_places(workers, keys);
    for (std::size_t i = 0; i < slots.size(); ++i) places_[slots[i]] = canonical.places[i];
    total_ = canonical.total;
  }
  std::int64_t total() const { return total_; }

  /// Moves all samples to where the canonical order has them.
  OwnSamples in_order(WorkerGroup& workers) {
    const std::vector<std::int64_t> cuts = equal_cuts(total_, workers.size());
    const std::vector<std::uint32_t> slots = all_slots();
    std::vector<std::int64_t> places;
    for (const std::uint32_t slot : slots) places.push_back(places_[slot]);
    return {moved_to_places(workers, *this, slots, places, cuts),
            {.total = total_, .before = cuts[static_cast<std::size_t>(workers.rank())]}};
  }

  ScoringTargets& scoring() { return scoring_; }

 private:
  std::vector<std::uint32_t> all_slots() const {
    std::vector<std::uint32_t> slots;
    for (std::int64_t i = 0; i < samples_.capacity(); ++i) {
      if (samples_.is_set(i)) slots.push_back(static_cast<std::uint32_t>(i));
    }
    return slots;
  }
  std::span<std::int16_t> scoring_row(std::uint32_t slot) {
    const auto dimensions = static_cast<std::size_t>(scoring_.dimensions);
    return std::span(scoring_.values).subspan(slot * dimensions, dimensions);
  }

  TrainingSamples& samples_;
  ScoringTargets scoring_;
  std::vector<std::int64_t> places_;
  std::vector<std::uint32_t> free_;
  std::int64_t total_ = 0;
};

/// The hash of all workers' samples in order.
std::uint64_t hash_of_all(WorkerGroup& workers, const TrainingSamples& samples, const OwnSamples& own) {
  std::vector<std::uint64_t> hashes(own.samples.size());
  parallel_for(std::ssize(hashes), [&](std::int64_t i) {
    hashes[static_cast<std::size_t>(i)] = samples.hash_of(own.samples[static_cast<std::size_t>(i)]);
  });
  return chained_hash(workers, hashes);
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
  check(options);
  if (samples.set_count() == 0) fail("forest training: there are no samples");
  check_training_memory(samples.capacity(), samples.feature_count(), samples.target_count(), options);
  const TrainingSamples::CanonicalOrder order = samples.canonical_order();
  const ScoringTargets scoring =
      make_scoring_targets(samples, {order.indices}, target_weights, options.scoring_dimensions);

  const std::string fingerprint = fingerprint_of(options, target_weights, order.hash);
  Parts parts = first_parts(samples, run.checkpoint, fingerprint);
  const auto append = [&](const Tree& tree) {
    append_tree(parts, samples, tree);
    write_parts(run.checkpoint, fingerprint, parts);
  };
  const PixelPairFeatures features(samples);
  with_statistics(scoring, [&](const auto& statistics) {
    grow_trees(features, statistics, options.tree, order.indices, parts.trees.roots.size(),
               static_cast<std::size_t>(options.trees), run, fingerprint, append);
  });
  remove_checkpoint(run.checkpoint);
  return RegressionForest(std::move(parts), "forest training").with_leaf_bits(options.leaf_bits);
}

std::optional<RegressionForest> train_regression_forest(WorkerGroup& workers, TrainingSamples& samples,
                                                        std::int64_t first_number,
                                                        const RegressionForestOptions& options,
                                                        const TrainingRun& run,
                                                        std::span<const double> target_weights) {
  check(options);
  check_training_memory(samples.capacity(), samples.feature_count(), samples.target_count(), options);
  MovingSamples moving(samples);
  moving.set_places(workers, first_number);
  if (moving.total() == 0) fail("forest training: there are no samples");
  // This worker's part of what all say that they have.
  check_training_memory(part_of_worker(moving.total(), workers.rank(), workers.size()).size(),
                        samples.feature_count(), samples.target_count(), options);
  const OwnSamples first = moving.in_order(workers);
  const std::string fingerprint =
      fingerprint_of(options, target_weights, hash_of_all(workers, samples, first));
  moving.scoring() =
      make_scoring_targets(samples, {.order = first.samples, .workers = &workers, .count = first.count},
                           target_weights, options.scoring_dimensions);

  Parts parts = first_parts(samples, run.checkpoint, fingerprint);
  const auto append = [&](const SharedTree<PixelPair>& tree) {
    append_tree(parts, workers, samples, tree);
    write_parts(run.checkpoint, fingerprint, parts);
  };
  const MoveSamples move = [&](auto slots, auto places, auto cuts) {
    return moved_to_places(workers, moving, slots, places, cuts);
  };
  const std::size_t first_tree = values_of_all(workers, parts.trees.roots.size())[0];
  with_statistics(moving.scoring(), [&](const auto& statistics) {
    grow_shared_trees(
        workers, PixelPairFeatures(samples), statistics, options.tree,
        [&] { return moving.in_order(workers); }, move, first_tree, static_cast<std::size_t>(options.trees),
        run, fingerprint, append);
  });
  remove_checkpoint(run.checkpoint);
  if (workers.rank() != 0) return std::nullopt;
  return RegressionForest(std::move(parts), "forest training").with_leaf_bits(options.leaf_bits);
}

}  // namespace knuckle
