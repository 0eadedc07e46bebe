// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/regression_forest.h"

#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::RandomRows;
using testing::written_model;

RegressionForest small_regression_forest(int leaf_bits = 16) {
  RegressionForestOptions options;
  options.trees = 4;
  options.tree.splits_per_node = 50;
  options.tree.min_leaf_samples = 1;
  options.leaf_bits = leaf_bits;
  return train_regression_forest(RandomRows(300, 30, 5).samples(), options);
}

/// The walk as the paper states it, recursive.
std::uint32_t leaf_of(const RegressionForest& forest, std::int32_t index,
                      const std::vector<float>& features) {
  const RegressionForest::Node& node = forest.parts().trees.nodes[static_cast<std::size_t>(index)];
  if (node.next < 0) return static_cast<std::uint32_t>(~node.next);
  const FeatureQuantizer& quantized = forest.parts().quantizer;
  const int difference = quantized(features[node.feature.first]) - quantized(features[node.feature.second]);
  return leaf_of(forest, difference >= node.threshold ? node.next + 1 : node.next, features);
}

TEST(RegressionForest, FlatWalkIsTheRecursiveWalk) {
  const RegressionForest forest = small_regression_forest();
  for (const std::vector<float>& features : RandomRows(200, 30, 1, 99).features) {
    const std::vector<std::uint32_t> leaves = forest.leaves_of(features);
    std::vector<double> sum(5, 0.0);
    for (std::size_t tree = 0; tree < 4; ++tree) {
      const std::uint32_t leaf =
          leaf_of(forest, static_cast<std::int32_t>(forest.parts().trees.roots[tree]), features);
      ASSERT_EQ(leaves[tree], leaf);
      std::vector<float> row(5);
      forest.parts().leaves.decode(leaf, row);
      for (std::size_t d = 0; d < 5; ++d) sum[d] += row[d];
    }
    const RegressionForest::Prediction prediction = forest.predict(features);
    for (std::size_t d = 0; d < 5; ++d) ASSERT_EQ(prediction.mean[d], static_cast<float>(sum[d] / 4.0));
  }
}

TEST(RegressionForest, DeviationIsThatOfTheTrees) {
  RegressionForest::Parts parts;
  parts.feature_count = 1;
  parts.trees.roots = {0, 1};
  parts.trees.nodes = {{~0, {}, 0}, {~1, {}, 0}};
  parts.leaves = LeafTable(1, std::vector<float>{1.0F, 4.0F}, 32);
  const RegressionForest forest(parts, "test");
  const std::vector<float> features{0.0F};
  EXPECT_FLOAT_EQ(forest.predict(features).mean[0], 2.5F);
  EXPECT_FLOAT_EQ(forest.predict(features).deviation[0], 1.5F);
  const std::vector<float> two{0.0F, 0.0F};
  EXPECT_THAT(error_of([&] { forest.predict(two); }), HasSubstr("2 features, expected 1"));
}

TEST(RegressionForest, SavedAndLoadedAnswersTheSame) {
  for (const int bits : {8, 16, 32}) {
    const RegressionForest forest = small_regression_forest(bits);
    const RegressionForest loaded =
        read_forest(written_model([&](ModelWriter& file) { write_forest(file, forest); }));
    EXPECT_EQ(loaded.parts().leaves.bits(), bits);
    for (const std::vector<float>& features : RandomRows(100, 30, 1, 99).features) {
      ASSERT_EQ(loaded.leaves_of(features), forest.leaves_of(features));
      ASSERT_EQ(loaded.predict(features).mean, forest.predict(features).mean);
    }
  }
}

TEST(RegressionForest, RefusesNodesThatLeadNowhere) {
  const RegressionForest::Parts good = small_regression_forest().parts();
  const auto fault_of = [&](const std::function<void(RegressionForest::Parts&)>& damage) {
    RegressionForest::Parts parts = good;
    damage(parts);
    return error_of([&] { RegressionForest(parts, "x.model"); });
  };
  EXPECT_THAT(fault_of([](auto& p) { p.trees.nodes[0].next = 0; }),
              AllOf(HasSubstr("x.model"), HasSubstr("leads nowhere")));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.nodes[0].next = static_cast<int>(p.trees.roots[1]); }),
              HasSubstr("leads nowhere"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.nodes[1].next = ~1000000; }), HasSubstr("leads nowhere"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.nodes[0].feature.first = 30; }), HasSubstr("beyond the 30"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.roots[1] = p.trees.roots[2]; }), HasSubstr("no nodes"));
  EXPECT_THAT(fault_of([](auto& p) { p.quantizer.step = NAN; }), HasSubstr("step"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.roots.clear(); }), HasSubstr("no first tree"));
  EXPECT_THAT(fault_of([](auto& p) { p.trees.roots[3] = static_cast<std::uint32_t>(p.trees.nodes.size()); }),
              HasSubstr("tree 3 has no nodes"));
  EXPECT_THAT(fault_of([](auto& p) { p.feature_count = 0; }), HasSubstr("x.model: a forest on 0 features"));
  EXPECT_THAT(fault_of([](auto& p) { p.leaves = {}; }), HasSubstr("x.model: the forest predicts nothing"));
}

TEST(RegressionForest, IsPrunedWithAScalePerTarget) {
  EXPECT_THAT(error_of([] { small_regression_forest().pruned(10, std::vector<float>(4, 1.0F)); }),
              HasSubstr("pruning: 4 scales for 5 targets"));
}

TEST(RegressionForest, RefusesFilesOfWhichAPartIsWrong) {
  const auto fault_of = [](const std::function<void(ModelWriter&)>& write) {
    return error_of([&] { read_forest(written_model(write)); });
  };
  EXPECT_THAT(fault_of([](ModelWriter& file) {
                write_forest(file, small_regression_forest());
                file.set("leaf_bits", 12.0);
              }),
              AllOf(HasSubstr("test.model"), HasSubstr("leaf_bits")));
  EXPECT_THAT(fault_of([](ModelWriter& file) {
                file.set("feature_count", 3.0);
                file.set("feature_step", 0.1);
              }),
              AllOf(HasSubstr("test.model"), HasSubstr("tree_root")));

  // A forest of one leaf, in a file that is written by hand.
  struct File {
    std::vector<std::uint32_t> roots = {0};
    std::vector<std::int16_t> thresholds = {0};
    std::vector<float> offset = {0.0F, 0.0F};
    std::vector<std::uint64_t> value_shape = {1, 2};
  };
  const auto fault_with = [&](const std::function<void(File&)>& change) {
    File parts;
    change(parts);
    return fault_of([&](ModelWriter& file) {
      file.set("feature_count", 3.0);
      file.set("feature_step", 0.1);
      file.add("tree_root", {parts.roots.size()}, parts.roots);
      file.add("node_is_leaf", {1}, std::vector<std::uint8_t>{1});
      file.add("node_first", {1}, std::vector<std::uint16_t>{0});
      file.add("node_second", {1}, std::vector<std::uint16_t>{0});
      file.add("node_threshold", {parts.thresholds.size()}, parts.thresholds);
      file.set("leaf_bits", 32.0);
      file.add("leaf_offset", {parts.offset.size()}, parts.offset);
      file.add("leaf_step", {2}, std::vector<float>{1.0F, 1.0F});
      file.add("leaf_value", parts.value_shape, std::vector<float>{1.0F, 2.0F});
    });
  };
  EXPECT_THAT(fault_with([](File& parts) { parts.roots.assign(4097, 0); }),
              HasSubstr("a forest of 4097 trees and 1 nodes, expected at most 4096"));
  EXPECT_THAT(fault_with([](File& parts) {
                parts.thresholds = {0, 0};
              }),
              HasSubstr("node_threshold is of another shape, expected one value for each of 1 nodes"));
  EXPECT_THAT(fault_with([](File& parts) { parts.offset.clear(); }),
              HasSubstr("leaf_offset is empty, expected a value per target"));
  EXPECT_THAT(fault_with([](File& parts) {
                parts.value_shape = {2, 1};
              }),
              HasSubstr("leaf_value does not have rows of 2 values"));
  EXPECT_THAT(fault_with([](File& parts) { parts.value_shape = {2}; }),
              HasSubstr("leaf_value does not have rows of 2 values"));
}

}  // namespace
}  // namespace knuckle
