// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "knuckle/core/parallel.h"
#include "knuckle/core/random.h"
#include "knuckle/forest/split_options.h"
#include "knuckle/forest/split_score.h"
#include "knuckle/forest/value_bins.h"

namespace knuckle {

/// What the engine asks of a kind of split feature: candidates, a compact copy of a node's samples to try
/// them on, and the value of one sample. Values are 16-bit whole numbers; a sample goes right where value >=
/// threshold.
template <class T>
concept SplitFeatures = requires(const T features, Random& random, typename T::Block& block,
                                 typename T::Feature feature, std::span<const std::uint32_t> samples,
                                 std::int16_t* values) {
  { features.draw(random, 0, 1) } -> std::same_as<typename T::Feature>;
  features.gather(samples, parallel_for, block);
  T::values(block, feature, values);
  { features.value(0U, feature) } -> std::same_as<std::int16_t>;
};

/// What the engine asks of the statistics of targets: made ready once a node, then asked for the best of the
/// thresholds of a candidate.
template <class T>
concept SplitStatistics = requires(const T statistics, typename T::Node& node,
                                   typename T::Histogram& histogram, std::span<const std::uint32_t> samples,
                                   const std::uint8_t* bins) {
  statistics.assign(samples, node);
  { node.best_split(bins, 2, 1, histogram) } -> std::same_as<BinSplit>;
};

/// A split of a node: right where feature >= threshold. No split is worth it where `gain` is 0.
template <class Feature>
struct NodeSplit {
  Feature feature{};
  std::int16_t threshold = 0;
  float gain = 0.0F;
};

/// Calls `work(i)` for i = 0, ..., count - 1 in order: the sequential twin of parallel_for.
inline void serial_for(std::int64_t count, const std::function<void(std::int64_t)>& work) {
  for (std::int64_t i = 0; i < count; ++i) work(i);
}

/// Bins that a candidate's values are parted into in a node of `samples` scored samples: half as many as
/// samples, so that the cost of a small node falls with its size, and at most options.threshold_bins.
inline int bins_for(const TreeOptions& options, std::size_t samples) {
  return static_cast<int>(
      std::clamp<std::size_t>(samples / 2, 2, static_cast<std::size_t>(options.threshold_bins)));
}

/// Finds the best split of one node after another; keeps its working memory.
///
/// The floor: a candidate costs each sample two loads and a difference (SIMD, contiguous), its bin (SIMD),
/// and the addition of its row of targets to that bin's sum (kLanes / 8 loads, adds and stores); each bin
/// costs a prefix sum and a squared norm.
template <SplitFeatures Features, SplitStatistics Statistics>
class SplitSearch {
 public:
  using Feature = typename Features::Feature;
  using Loop = void (*)(std::int64_t count, const std::function<void(std::int64_t)>& work);

  /// The best of options.splits_per_node candidates drawn from `random`; of equal ones the first drawn.
  /// `loop` runs the work on one thread or all; the result is the same.
  NodeSplit<Feature> best_split(const Features& features, const Statistics& statistics,
                                std::span<const std::uint32_t> samples, const TreeOptions& options,
                                Random& random, Loop loop);

 private:
  /// Candidates tried by one call of the loop's body.
  static constexpr std::int64_t kCandidatesAChunk = 256;

  NodeSplit<Feature> best_of(std::span<const Feature> candidates, const TreeOptions& options) const;

  typename Features::Block block_;
  typename Statistics::Node node_;
  std::vector<Feature> candidates_;
};

template <SplitFeatures Features, SplitStatistics Statistics>
auto SplitSearch<Features, Statistics>::best_split(const Features& features, const Statistics& statistics,
                                                   std::span<const std::uint32_t> samples,
                                                   const TreeOptions& options, Random& random, Loop loop)
    -> NodeSplit<Feature> {
  features.gather(samples, loop, block_);
  statistics.assign(samples, node_);
  candidates_.clear();
  for (int i = 0; i < options.splits_per_node; ++i) {
    candidates_.push_back(features.draw(random, i, options.splits_per_node));
  }
  const std::int64_t count = std::ssize(candidates_);
  const std::int64_t chunks = (count + kCandidatesAChunk - 1) / kCandidatesAChunk;
  std::vector<NodeSplit<Feature>> best(static_cast<std::size_t>(chunks));
  loop(chunks, [&](std::int64_t chunk) {
    const std::int64_t first = chunk * kCandidatesAChunk;
    const std::int64_t size = std::min(kCandidatesAChunk, count - first);
    best[static_cast<std::size_t>(chunk)] = best_of(
        std::span(candidates_).subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(size)),
        options);
  });
  return *std::ranges::max_element(best, {}, &NodeSplit<Feature>::gain);
}

template <SplitFeatures Features, SplitStatistics Statistics>
auto SplitSearch<Features, Statistics>::best_of(std::span<const Feature> candidates,
                                                const TreeOptions& options) const -> NodeSplit<Feature> {
  const std::size_t samples = block_.sample_count;
  std::vector<std::int16_t> values(samples);
  std::vector<std::uint8_t> bins(samples);
  typename Statistics::Histogram histogram;
  NodeSplit<Feature> best;
  for (const Feature& candidate : candidates) {
    Features::values(block_, candidate, values.data());
    const ValueBins parts(values, bins_for(options, samples));
    if (parts.count() < 2) continue;
    parts.assign(values, bins.data());
    const BinSplit split = node_.best_split(bins.data(), parts.count(), options.min_leaf_samples, histogram);
    if (split.gain > best.gain) {
      best = {candidate, static_cast<std::int16_t>(parts.first_value(split.bin)), split.gain};
    }
  }
  return best;
}

}  // namespace knuckle
