// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/random.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/scoring_targets.h"
#include "knuckle/forest/split_search.h"

namespace knuckle {
namespace {

constexpr int kPatchSize = 96;
constexpr int kPixels = kPatchSize * kPatchSize;
constexpr int kTargets = 66;  // u, v, d of 22 landmarks
constexpr int kTrees = 8;

std::vector<float> random_row(Random& random, int length) {
  std::vector<float> row(static_cast<std::size_t>(length));
  for (float& value : row) value = static_cast<float>(random.uniform(-3.0, 3.0));
  return row;
}

/// Full trees of random splits: 2^16 leaves a tree is about what 4 * 10^5 patches grow.
RegressionForest random_forest(int depth) {
  Random random(1);
  RegressionForest::Parts parts;
  parts.feature_count = kPixels;
  const std::int32_t inner = (1 << depth) - 1;
  std::int32_t leaf = 0;
  for (int tree = 0; tree < kTrees; ++tree) {
    const auto root = static_cast<std::int32_t>(parts.trees.nodes.size());
    parts.trees.roots.push_back(static_cast<std::uint32_t>(root));
    for (std::int32_t i = 0; i < inner; ++i) {
      const auto first = static_cast<std::uint16_t>(random.below(kPixels));
      const auto second = static_cast<std::uint16_t>(random.below(kPixels));
      const auto threshold = static_cast<std::int16_t>(random.uniform(-1000.0, 1000.0));
      parts.trees.nodes.push_back({root + 2 * i + 1, {first, second}, threshold});
    }
    for (std::int32_t i = 0; i <= inner; ++i) parts.trees.nodes.push_back({~leaf++, {}, 0});
  }
  std::vector<std::uint16_t> codes(static_cast<std::size_t>(leaf) * kTargets);
  for (std::uint16_t& code : codes) code = static_cast<std::uint16_t>(random());
  parts.leaves = LeafTable(std::vector<float>(kTargets, -1.0F), std::vector<float>(kTargets, 1e-4F),
                           std::move(codes), "bench");
  return {std::move(parts), "bench"};
}

void estimate_pose_forest(benchmark::State& state) {
  const PoseForestEstimator estimator({convention_from_name("knuckle22"), {}, random_forest(16)});
  std::vector<HandPatch> patches(64);
  Random random(2);
  for (HandPatch& patch : patches) {
    patch.pixels = Image<float>(kPatchSize, kPatchSize);
    for (float& pixel : patch.pixels.pixels()) pixel = static_cast<float>(random.uniform(-3.0, 3.0));
  }
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(estimator.estimate(patches[next]));
    next = (next + 1) % patches.size();
  }
}
BENCHMARK(estimate_pose_forest)->Name("estimate/pose_forest")->Unit(benchmark::kMicrosecond);

TrainingSamples random_samples(int count) {
  TrainingSamples samples(count, kPixels, kTargets);
  parallel_for(count, [&](std::int64_t i) {
    Random random(3, static_cast<std::uint64_t>(i));
    samples.set(i, random_row(random, kPixels), random_row(random, kTargets));
  });
  return samples;
}

/// The copy of a node's samples that candidates are tried on; items are pixels.
void gather(benchmark::State& state) {
  const auto count = static_cast<int>(state.range(0));
  const TrainingSamples samples = random_samples(count);
  std::vector<std::uint32_t> node(static_cast<std::size_t>(count));
  std::iota(node.begin(), node.end(), 0U);
  PixelPairFeatures::Block block;
  for (auto _ : state) PixelPairFeatures(samples).gather(node, serial_for, block);
  state.SetItemsProcessed(state.iterations() * count * kPixels);
}
BENCHMARK(gather)->Name("forest/gather")->Arg(128)->Arg(5000)->Unit(benchmark::kMillisecond);

/// One node of state.range(0) samples; items are candidates times samples.
void best_split(benchmark::State& state) {
  const auto count = static_cast<int>(state.range(0));
  const TrainingSamples samples = random_samples(count);
  std::vector<std::uint32_t> node(static_cast<std::size_t>(count));
  std::iota(node.begin(), node.end(), 0U);
  TreeOptions options;
  const ScoringTargets targets = make_scoring_targets(samples, {node}, {}, 15);
  const PixelPairFeatures features(samples);
  const VarianceStatistics<16> statistics(targets);
  SplitSearch<PixelPairFeatures, VarianceStatistics<16>> search;
  for (auto _ : state) {
    Random random(4);
    benchmark::DoNotOptimize(search.best_split(features, statistics, node, options, random, serial_for));
  }
  state.SetItemsProcessed(state.iterations() * count * options.splits_per_node);
}
BENCHMARK(best_split)
    ->Name("forest/best_split/10000_candidates")
    ->Arg(16)
    ->Arg(128)
    ->Arg(1024)
    ->Arg(5000)
    ->Unit(benchmark::kMillisecond);

/// One tree on 2000 patches of noise, 1000 candidates a node.
void train_tree(benchmark::State& state) {
  const TrainingSamples samples = random_samples(2000);
  RegressionForestOptions options;
  options.trees = 1;
  options.tree.splits_per_node = 1000;
  show_progress(false);
  for (auto _ : state) benchmark::DoNotOptimize(train_regression_forest(samples, options));
  show_progress(true);
}
BENCHMARK(train_tree)->Name("forest/train_tree/2000x96x96")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace knuckle
