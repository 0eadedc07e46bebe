// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/pruning.h"

#include <algorithm>
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/pixel_forest_trainer.h"
#include "knuckle/forest/regression_forest.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;

/// One tree: a root, its left child an inner node with leaves 1 and 2, its right child one with leaves 7
/// and 9.
const std::vector<std::int32_t> kNext = {1, 3, 5, ~0, ~1, ~2, ~3};
const std::vector<std::uint32_t> kRoots = {0};
const std::vector<float> kScale = {1.0f};

LeafRows four_leaves() {
  return {1, {1.0f, 2.0f, 7.0f, 9.0f}};
}

TEST(Pruning, MergesTheNearestLeavesFirst) {
  const PrunedNodes three = pruned_nodes(kNext, kRoots, four_leaves(), kScale, 3);
  EXPECT_THAT(three.is_kept, ElementsAre(1, 1, 1, 0, 0, 1, 1));
  EXPECT_THAT(three.leaves.values, ElementsAre(1.5f, 7.0f, 9.0f));
  const PrunedNodes two = pruned_nodes(kNext, kRoots, four_leaves(), kScale, 2);
  EXPECT_THAT(two.leaves.values, ElementsAre(1.5f, 8.0f));
}

TEST(Pruning, ALeafThatWasMergedWeighsMore) {
  // One tree of the leaves (0, 0) and 10, whose first two are merged at once, and one of 50 and 61. Then
  // merging the first tree costs 2/3 10^2, and merging the second 1/2 11^2, which is less.
  const std::vector<std::int32_t> next = {1, 3, ~2, ~0, ~1, 6, ~3, ~4};
  const std::vector<std::uint32_t> roots = {0, 5};
  const LeafRows leaves{1, {0.0f, 0.0f, 10.0f, 50.0f, 61.0f}};
  EXPECT_THAT(pruned_nodes(next, roots, leaves, kScale, 3).leaves.values, ElementsAre(0.0f, 10.0f, 55.5f));
  EXPECT_THAT(pruned_nodes(next, roots, leaves, kScale, 2).leaves.values, ElementsAre(10.0f / 3.0f, 55.5f));
}

TEST(Pruning, KeepsAtLeastARootWithTheMeanOfAllLeaves) {
  const PrunedNodes one = pruned_nodes(kNext, kRoots, four_leaves(), kScale, 0);
  EXPECT_THAT(one.is_kept, ElementsAre(1, 0, 0, 0, 0, 0, 0));
  EXPECT_THAT(one.leaves.values, ElementsAre(4.75f));
}

TEST(Pruning, ADimensionThatCountsNothingDoesNotDecide) {
  const LeafRows leaves{2, {0, 1, 0, 2, 0, 7, 100, 7}};
  const PrunedNodes pruned = pruned_nodes(kNext, kRoots, leaves, std::vector<float>{0.0f, 1.0f}, 3);
  EXPECT_THAT(pruned.leaves.values, ElementsAre(50, 7, 0, 1, 0, 2)) << "in the order of the nodes";
}

class GrownForest : public ::testing::Test {
 protected:
  GrownForest() {
    options_.trees = 3;
    options_.tree.max_depth = 8;
    options_.tree.splits_per_node = 20;
    options_.tree.min_leaf_samples = 2;
    options_.leaf_bits = 32;
  }

  static double squared_error(const RegressionForest& forest, const testing::RandomRows& rows) {
    double sum = 0.0;
    for (std::size_t i = 0; i < rows.features.size(); ++i) {
      const auto mean = forest.predict(rows.features[i]).mean;
      for (std::size_t d = 0; d < mean.size(); ++d) {
        sum += (mean[d] - rows.targets[i][d]) * (mean[d] - rows.targets[i][d]);
      }
    }
    return sum;
  }

  RegressionForestOptions options_;
  testing::RandomRows rows_{400, 12, 3};
  const std::vector<float> scale_ = {1.0f, 1.0f, 1.0f};
};

TEST_F(GrownForest, AnswersAsBeforeWhereNothingIsMerged) {
  const RegressionForest forest = train_regression_forest(rows_.samples(), options_);
  const RegressionForest same = forest.pruned(std::numeric_limits<std::size_t>::max(), scale_);
  for (const auto& features : rows_.features) {
    EXPECT_EQ(same.predict(features).mean, forest.predict(features).mean);
  }
}

TEST_F(GrownForest, FewerLeavesAnswerWorseButNeverWorseThanTheMean) {
  const RegressionForest forest = train_regression_forest(rows_.samples(), options_);
  const std::size_t whole = forest.parts().leaves.leaf_count();
  double before = squared_error(forest, rows_);
  for (const std::size_t most : {whole / 2, whole / 8, std::size_t{3}}) {
    const RegressionForest small = forest.pruned(most, scale_);
    EXPECT_EQ(small.parts().leaves.leaf_count(), most);
    const double error = squared_error(small, rows_);
    EXPECT_GT(error, before);
    before = error;
  }
}

TEST_F(GrownForest, LosesLessThanByMergingAnyLeaves) {
  const RegressionForest forest = train_regression_forest(rows_.samples(), options_);
  const std::size_t half = forest.parts().leaves.leaf_count() / 2;
  const std::vector<float> blind = {0.0f, 0.0f, 0.0f};  // all merge at once the same cost
  EXPECT_LT(squared_error(forest.pruned(half, scale_), rows_),
            squared_error(forest.pruned(half, blind), rows_));
}

TEST_F(GrownForest, KeepsEveryTreeOfAPixelForest) {
  const std::vector<testing::BallScene> scenes = testing::ball_scenes(6);
  PixelForestOptions options;
  options.trees = 2;
  options.tree.max_depth = 6;
  options.tree.splits_per_node = 50;
  const PixelForest forest = train_pixel_forest(testing::samples_of(scenes), options);
  const PixelForest stumps = forest.pruned(1);
  EXPECT_EQ(stumps.tree_count(), 2);
  EXPECT_EQ(stumps.parts().leaf_codes.size(), 2u);
  const Image<float> probability = stumps.probability(scenes[0].depth_mm, scenes[0].camera);
  const auto pixels = probability.pixels();
  const std::set<float> values(pixels.begin(), pixels.end());
  EXPECT_EQ(values.size(), 2u) << "0 where nothing is measured, one value elsewhere";
}

}  // namespace
}  // namespace knuckle
