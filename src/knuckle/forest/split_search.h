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
#include "knuckle/forest/feature_rows.h"
#include "knuckle/forest/split_options.h"
#include "knuckle/forest/split_score.h"

namespace knuckle {

/// What the engine asks of a kind of split feature: candidates, a compact copy of a node's samples to try
/// them on, and the value of one sample. Values are 16-bit whole numbers; a sample goes right where value >=
/// threshold. A Candidate names what it reads by its place in the Block; feature() turns it into what a tree
/// keeps.
template <class T>
concept SplitFeatures = requires(const T features, Random& random, const TreeOptions& options,
                                 typename T::Block& block, const typename T::Block& filled,
                                 typename T::Candidate candidate, typename T::Feature feature,
                                 std::span<const std::uint32_t> samples, std::int16_t* values) {
  features.begin_node(random, options, block);
  features.gather(samples, parallel_for, block);
  { features.draw(random, 0, 1, filled) } -> std::same_as<typename T::Candidate>;
  T::values(filled, candidate, values);
  { T::feature(filled, candidate) } -> std::same_as<typename T::Feature>;
  { features.can_read(feature) } -> std::same_as<bool>;  // of one that comes from a file or a worker
  { features.value(0U, feature) } -> std::same_as<std::int16_t>;
};

/// What the engine asks besides, where samples are spread over several workers: the numbers that a node's
/// candidates read of a sample, so that another worker can try them.
template <class T>
concept SharedFeatures = SplitFeatures<T> &&
    requires(const T features, typename T::Block& block, std::int16_t* row) {
  { features.row_length(block) } -> std::same_as<std::size_t>;
  features.read_row(0U, block, row);
  { T::rows_of(block) } -> std::same_as<FeatureRows&>;
};

/// What the engine asks of the statistics of targets: made ready once a node, then asked for the best
/// threshold of each candidate. samples() says in which order (and how often: to fill SIMD registers) it
/// wants the samples' values.
template <class T>
concept SplitStatistics = requires(const T statistics, typename T::Node& node, const typename T::Node& ready,
                                   typename T::Scratch& scratch, std::span<const std::uint32_t> samples,
                                   std::span<const std::int16_t> values, const TreeOptions& options) {
  statistics.assign(samples, node);
  { ready.samples() } -> std::same_as<std::span<const std::uint32_t>>;
  { ready.is_pure() } -> std::same_as<bool>;
  { ready.best_split(values, std::size_t{0}, options, scratch) } -> std::same_as<ThresholdSplit>;
};

/// What the engine asks besides, where samples are spread over several workers: the targets of a sample as
/// 16-bit numbers, and statistics of samples whose numbers came from others: sample i of them is rows[i].
template <class T>
concept SharedStatistics = SplitStatistics<T> &&
    requires(const T statistics, std::int16_t* target, std::span<const std::int16_t* const> rows) {
  { statistics.target_length() } -> std::same_as<std::size_t>;
  statistics.read_target(0U, target);
  { statistics.received(rows).statistics() } -> std::same_as<T>;
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

/// Finds the best split of one node after another; keeps its working memory.
///
/// The floor: a candidate costs each sample two loads and a difference (SIMD, contiguous), and what the
/// statistics make of its value: an addition to a histogram, or a comparison with each threshold.
template <SplitFeatures Features, SplitStatistics Statistics>
class SplitSearch {
 public:
  using Feature = typename Features::Feature;
  using Candidate = typename Features::Candidate;
  using Loop = void (*)(std::int64_t count, const std::function<void(std::int64_t)>& work);

  /// The best of options.splits_per_node candidates drawn from `random`; of equal ones the first drawn.
  /// `loop` runs the work on one thread or all; the result is the same. `features` draws candidates and
  /// copies samples as Features does.
  template <class Source>
  NodeSplit<Feature> best_split(const Source& features, const Statistics& statistics,
                                std::span<const std::uint32_t> samples, const TreeOptions& options,
                                Random& random, Loop loop);

 private:
  /// Candidates tried by one call of the loop's body.
  static constexpr std::size_t kCandidatesPerChunk = 256;

  NodeSplit<Feature> best_of(std::size_t first, std::size_t end, const TreeOptions& options) const;

  typename Features::Block block_;
  typename Statistics::Node node_;
  std::vector<Candidate> candidates_;
};

template <SplitFeatures Features, SplitStatistics Statistics>
template <class Source>
auto SplitSearch<Features, Statistics>::best_split(const Source& features, const Statistics& statistics,
                                                   std::span<const std::uint32_t> samples,
                                                   const TreeOptions& options, Random& random, Loop loop)
    -> NodeSplit<Feature> {
  statistics.assign(samples, node_);
  if (node_.is_pure()) return {};
  features.begin_node(random, options, block_);
  features.gather(node_.samples(), loop, block_);
  candidates_.clear();
  for (int i = 0; i < options.splits_per_node; ++i) {
    candidates_.push_back(features.draw(random, i, options.splits_per_node, block_));
  }
  const std::size_t chunks = (candidates_.size() + kCandidatesPerChunk - 1) / kCandidatesPerChunk;
  std::vector<NodeSplit<Feature>> best(chunks);
  loop(static_cast<std::int64_t>(chunks), [&](std::int64_t index) {
    const auto chunk = static_cast<std::size_t>(index);
    const std::size_t first = chunk * kCandidatesPerChunk;
    best[chunk] = best_of(first, std::min(first + kCandidatesPerChunk, candidates_.size()), options);
  });
  return *std::ranges::max_element(best, {}, &NodeSplit<Feature>::gain);
}

template <SplitFeatures Features, SplitStatistics Statistics>
auto SplitSearch<Features, Statistics>::best_of(std::size_t first, std::size_t end,
                                                const TreeOptions& options) const -> NodeSplit<Feature> {
  std::vector<std::int16_t> values(node_.samples().size());
  typename Statistics::Scratch scratch;
  NodeSplit<Feature> best;
  for (std::size_t i = first; i < end; ++i) {
    Features::values(block_, candidates_[i], values.data());
    const ThresholdSplit split = node_.best_split(values, i, options, scratch);
    if (split.gain > best.gain) {
      best = {Features::feature(block_, candidates_[i]), split.threshold, split.gain};
    }
  }
  return best;
}

}  // namespace knuckle
