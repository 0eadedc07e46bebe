// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/forest_trainer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/pixel_pairs.h"
#include "knuckle/forest/scoring_targets.h"
#include "knuckle/forest/split_score.h"
#include "knuckle/forest/tree_grower.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::RandomRows;
using testing::TemporaryFolder;

RegressionForestOptions small_regression_options() {
  RegressionForestOptions options;
  options.trees = 3;
  options.tree.splits_per_node = 40;
  options.tree.samples_per_node = 100;
  options.tree.min_leaf_samples = 2;
  return options;
}

void expect_same(const RegressionForest& a, const RegressionForest& b) {
  testing::expect_same_trees(a.parts().trees, b.parts().trees);
  EXPECT_EQ(a.parts().leaves.decoded(), b.parts().leaves.decoded());
}

TEST(TrainRegressionForest, MemorisesATinySetExactly) {
  const RandomRows rows(60, 50, 4);
  RegressionForestOptions options;
  options.trees = 5;
  options.tree.splits_per_node = 200;
  options.tree.min_leaf_samples = 1;
  options.leaf_bits = 32;
  const RegressionForest forest = train_regression_forest(rows.samples(), options);
  for (std::size_t i = 0; i < 60; ++i) {
    EXPECT_EQ(forest.predict(rows.features[i]).mean, rows.targets[i]);
  }
}

TEST(TrainRegressionForest, LeavesAreMeansOfAllSamplesThatReachThem) {
  const RandomRows rows(500, 20, 3);
  RegressionForestOptions options = small_regression_options();
  options.trees = 1;
  options.tree.max_depth = 3;
  options.leaf_bits = 32;
  const RegressionForest forest = train_regression_forest(rows.samples(), options);
  std::map<std::uint32_t, std::vector<std::size_t>> reached;
  for (std::size_t i = 0; i < 500; ++i) reached[forest.leaves_of(rows.features[i])[0]].push_back(i);
  EXPECT_EQ(reached.size(), 8U);
  for (const auto& [leaf, members] : reached) {
    std::vector<float> row(3);
    forest.parts().leaves.decode(leaf, row);
    for (std::size_t d = 0; d < 3; ++d) {
      double sum = 0.0;
      for (const std::size_t i : members) sum += rows.targets[i][d];
      EXPECT_NEAR(row[d], sum / static_cast<double>(members.size()), 1e-5);
    }
  }
}

TEST(TrainRegressionForest, LearnsADifferenceOfFeatures) {
  const RandomRows training(3000, 10, 1);
  const RandomRows test(300, 10, 1, 8);
  RegressionForestOptions options;
  options.trees = 8;
  options.tree.splits_per_node = 200;
  const RegressionForest forest = train_regression_forest(training.samples(), options);
  double error = 0.0;
  double spread = 0.0;
  for (std::size_t i = 0; i < 300; ++i) {
    error += std::pow(forest.predict(test.features[i]).mean[0] - test.targets[i][0], 2.0);
    spread += std::pow(test.targets[i][0], 2.0);
  }
  EXPECT_LT(error, 0.01 * spread);
}

TEST(TrainRegressionForest, DoesNotDependOnTheOrderOfSamples) {
  const RandomRows rows(400, 25, 20);  // more samples than a node scores, more targets than are scored
  RegressionForestOptions options = small_regression_options();
  options.tree.bagging_fraction = 0.7;
  std::vector<std::int64_t> place(400);
  std::iota(place.begin(), place.end(), 0);
  const RegressionForest forest = train_regression_forest(rows.samples_at(place), options);
  std::rotate(place.begin(), place.begin() + 123, place.end());
  std::reverse(place.begin(), place.begin() + 200);
  expect_same(forest, train_regression_forest(rows.samples_at(place), options));
}

TEST(TrainRegressionForest, DoesNotDependOnThreads) {
  const TrainingSamples samples = RandomRows(4000, 25, 20).samples();
  RegressionForestOptions options = small_regression_options();
  options.tree.samples_per_node =
      2000;  // nodes above and below the size that shares candidates among threads
  set_thread_count(1);
  const RegressionForest one = train_regression_forest(samples, options);
  set_thread_count(2);
  const RegressionForest two = train_regression_forest(samples, options);
  set_thread_count(0);
  expect_same(one, two);
}

TEST(TrainRegressionForest, SeedsAndTreesDiffer) {
  const TrainingSamples samples = RandomRows(300, 25, 3).samples();
  RegressionForestOptions options = small_regression_options();
  const RegressionForest forest = train_regression_forest(samples, options);
  const auto& nodes = forest.parts().trees.nodes;
  EXPECT_NE(nodes[0].threshold, nodes[forest.parts().trees.roots[1]].threshold);
  options.tree.seed = 2;
  EXPECT_NE(nodes[0].threshold, train_regression_forest(samples, options).parts().trees.nodes[0].threshold);
}

TEST(TrainRegressionForest, ConstantTargetsGiveOneLeaf) {
  RandomRows rows(100, 10, 2);
  for (auto& target : rows.targets) target = {0.1F, -7.0F};
  const RegressionForest forest = train_regression_forest(rows.samples(), small_regression_options());
  EXPECT_EQ(forest.parts().trees.nodes.size(), 3U);
  EXPECT_EQ(forest.predict(rows.features[0]).mean, rows.targets[0]);
}

TEST(TrainRegressionForest, KeepsDepthAndLeafSizes) {
  const RandomRows rows(300, 10, 2);
  RegressionForestOptions options = small_regression_options();
  options.trees = 1;
  options.tree.samples_per_node = 5000;
  options.tree.min_leaf_samples = 20;
  const RegressionForest forest = train_regression_forest(rows.samples(), options);
  std::map<std::uint32_t, int> reached;
  for (const auto& features : rows.features) ++reached[forest.leaves_of(features)[0]];
  for (const auto& [leaf, count] : reached) EXPECT_GE(count, 20) << leaf;
  options.tree.max_depth = 0;
  EXPECT_EQ(train_regression_forest(rows.samples(), options).parts().trees.nodes.size(), 1U);
}

TEST(TrainRegressionForest, RefusesNoSamplesAndBadOptions) {
  RegressionForestOptions options = small_regression_options();
  EXPECT_THAT(error_of([&] { train_regression_forest(TrainingSamples(5, 3, 2), options); }),
              HasSubstr("no samples"));
  options.leaf_bits = 9;
  const TrainingSamples samples = RandomRows(10, 3, 2).samples();
  EXPECT_THAT(error_of([&] { train_regression_forest(samples, options); }), HasSubstr("leaf_bits is 9"));
  options.leaf_bits = 8;
  options.tree.max_depth = 100;
  EXPECT_THAT(error_of([&] { train_regression_forest(samples, options); }), HasSubstr("max_depth"));
}

TEST(TrainRegressionForest, RefusesTooSmallAMemory) {
  RegressionForestOptions options;
  constexpr int kPixels = 96 * 96;
  EXPECT_LT(training_memory(400000, kPixels, 66, options), 9e9);  // the paper's scale
  options.memory_gb = 1.0;
  const std::string fault = error_of([&] { check_training_memory(400000, kPixels, 66, options); });
  EXPECT_THAT(fault,
              AllOf(HasSubstr("400000 samples"), HasSubstr("memory_gb is 1;"), HasSubstr("would fit")));
  const std::string told = "at most ";
  const std::int64_t fitting = std::stoll(fault.substr(fault.find(told) + told.size()));
  EXPECT_LE(training_memory(fitting, kPixels, 66, options), 1e9);
  EXPECT_GT(training_memory(fitting + 1, kPixels, 66, options), 1e9);
  options.memory_gb = 1e-6;
  const TrainingSamples samples = RandomRows(300, 25, 3).samples();
  EXPECT_THAT(error_of([&] { train_regression_forest(samples, options); }), HasSubstr("memory_gb"));
}

/// A training that stops after some trees, as a kill would: progress is only what the checkpoint holds.
TEST(TrainRegressionForest, GoesOnFromACheckpoint) {
  const TemporaryFolder folder;
  const TrainingSamples samples = RandomRows(300, 25, 3).samples();
  const RegressionForestOptions options = small_regression_options();
  const RegressionForest whole = train_regression_forest(samples, options);
  int trees_done = 0;
  const auto stop_at_second = [&](int trees) {
    trees_done = trees;
    if (trees == 2) throw Error("stopped");
  };
  const TrainingRun stopped{.checkpoint = folder / "c.model", .tree_done = stop_at_second};
  EXPECT_EQ(error_of([&] { train_regression_forest(samples, options, stopped); }), "stopped");
  EXPECT_TRUE(std::filesystem::exists(folder / "c.model"));

  RegressionForestOptions others = options;
  others.tree.seed = 9;
  const TrainingRun resumed{.checkpoint = folder / "c.model", .tree_done = [&](int) { ++trees_done; }};
  EXPECT_THAT(error_of([&] { train_regression_forest(samples, others, resumed); }),
              AllOf(HasSubstr("c.model"), HasSubstr("other options")));
  expect_same(whole, train_regression_forest(samples, options, resumed));
  EXPECT_EQ(trees_done, 3);
  EXPECT_FALSE(std::filesystem::exists(folder / "c.model"));
}

TEST(TrainRegressionForest, ACheckpointOfOtherWeightsOrSamplesIsRefused) {
  const TemporaryFolder folder;
  const TrainingSamples samples = RandomRows(300, 25, 3).samples();
  const RegressionForestOptions options = small_regression_options();
  const TrainingRun stopped{.checkpoint = folder / "c.h5", .tree_done = [](int) { throw Error("stopped"); }};
  const std::vector<double> weights{1.0, 1.0, 0.25};
  EXPECT_EQ(error_of([&] { train_regression_forest(samples, options, stopped, weights); }), "stopped");
  const auto fault = [&](const TrainingSamples& with, const std::vector<double>& weighted) {
    return error_of(
        [&] { train_regression_forest(with, options, {.checkpoint = folder / "c.h5"}, weighted); });
  };
  EXPECT_THAT(fault(samples, {1.0, 0.25, 1.0}), HasSubstr("other options or samples"));
  EXPECT_THAT(fault(samples, {}), HasSubstr("other options or samples"));
  EXPECT_THAT(fault(RandomRows(301, 25, 3).samples(), weights), HasSubstr("other options or samples"));
  RegressionForestOptions coarse = options;
  coarse.leaf_bits = 8;  // trees are the same: a training may go on to other leaves
  EXPECT_NO_THROW(train_regression_forest(samples, coarse, {.checkpoint = folder / "c.h5"}, weights));
}

TEST(TrainRegressionForest, RefusesAForeignCheckpoint) {
  const TemporaryFolder folder;
  std::ofstream(folder / "c.model") << "no checkpoint";
  const TrainingRun run{.checkpoint = folder / "c.model"};
  const TrainingSamples samples = RandomRows(10, 3, 2).samples();
  EXPECT_THAT(error_of([&] { train_regression_forest(samples, small_regression_options(), run); }),
              HasSubstr("c.model"));
}

/// Grows a tree from splits that a checkpoint says a stopped run has found.
std::string fault_of_log(const NodeSplit<PixelPair>& split) {
  const TrainingSamples samples = RandomRows(20, 3, 2).samples();
  const TrainingSamples::CanonicalOrder order = samples.canonical_order();
  const ScoringTargets scoring = make_scoring_targets(samples, {order.indices}, {}, 2);
  const PixelPairFeatures features(samples);
  const VarianceStatistics<8> statistics(scoring);
  TreeGrower grower(features, statistics, TreeOptions{.max_depth = 2, .splits_per_node = 5});
  Progress progress("grow", "steps", 1);
  SplitLog<PixelPair> log{split};
  return error_of([&] { grower.grow(order.indices, 1, progress, log, [](const auto&) {}); });
}

TEST(TreeGrower, SplitsOfACheckpointReadWhatSamplesHave) {
  EXPECT_THAT(fault_of_log({.feature = {0, 3}, .threshold = 0, .gain = 1.0F}),
              HasSubstr("what no sample has"));
}

TEST(TreeGrower, SplitsOfACheckpointPartSamples) {
  EXPECT_THAT(fault_of_log({.feature = {1, 1}, .threshold = 1, .gain = 1.0F}), HasSubstr("parts no samples"));
  EXPECT_THAT(fault_of_log({.feature = {1, 1}, .threshold = 0, .gain = 1.0F}), HasSubstr("parts no samples"));
}

}  // namespace
}  // namespace knuckle
