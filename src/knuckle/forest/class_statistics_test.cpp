// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/class_statistics.h"

#include <algorithm>
#include <numeric>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/offset_features.h"
#include "knuckle/forest/split_search.h"

namespace knuckle {
namespace {

using testing::ball_scenes;
using testing::samples_of;

/// n times Gini's impurity, from its definition: the chance that two samples drawn with replacement differ.
double impurity(const std::vector<std::uint8_t>& labels) {
  double differing = 0.0;
  for (const std::uint8_t a : labels) {
    for (const std::uint8_t b : labels) differing += a != b ? 1.0 : 0.0;
  }
  return labels.empty() ? 0.0 : differing / static_cast<double>(labels.size());
}

double impurity_reduction(const std::vector<std::int16_t>& values, const std::vector<std::uint8_t>& labels,
                          int threshold, int min_samples) {
  std::vector<std::uint8_t> side[2];
  for (std::size_t i = 0; i < values.size(); ++i) side[values[i] >= threshold ? 1 : 0].push_back(labels[i]);
  if (std::ssize(side[0]) < min_samples || std::ssize(side[1]) < min_samples) return 0.0;
  return impurity(labels) - impurity(side[0]) - impurity(side[1]);
}

TEST(ClassStatistics, GainIsTheReductionOfGinisImpurity) {
  Random random(2);
  for (const int count : {2, 3, 15, 16, 17, 100, 331}) {
    for (const int thresholds : {1, 3, 8, 40}) {
      std::vector<std::uint8_t> labels;
      std::vector<std::uint32_t> samples;
      std::vector<std::int16_t> value_of_sample;
      for (int i = 0; i < count; ++i) {
        samples.push_back(static_cast<std::uint32_t>(i));
        labels.push_back(i == 0 ? 0 : i == 1 ? 1 : static_cast<std::uint8_t>(random.below(2)));
        value_of_sample.push_back(static_cast<std::int16_t>(random.uniform(-20000, 20000)));
      }
      ClassStatistics::Node node;
      ClassStatistics(labels).assign(samples, node);
      ASSERT_FALSE(node.is_pure());
      std::vector<std::int16_t> values;
      for (const std::uint32_t sample : node.samples()) values.push_back(value_of_sample[sample]);
      TreeOptions options;
      options.threshold_bins = thresholds + 1;
      options.min_leaf_samples = count > 20 ? 5 : 1;
      ClassStatistics::Scratch scratch;
      const ThresholdSplit found = node.best_split(values, 3, options, scratch);
      if (found.gain > 0.0F) {
        const double expected =
            impurity_reduction(value_of_sample, labels, found.threshold, options.min_leaf_samples);
        EXPECT_NEAR(found.gain, expected, 1e-5 * expected) << count << " " << thresholds;
      }
      if (thresholds < count) continue;  // all values are tried: no threshold is better
      double best = 0.0;
      for (const std::int16_t threshold : value_of_sample) {
        best =
            std::max(best, impurity_reduction(value_of_sample, labels, threshold, options.min_leaf_samples));
      }
      EXPECT_NEAR(found.gain, best, 1e-5 * best);
    }
  }
}

TEST(ClassStatistics, BothSidesOfASplitKeepTheFewestSamples) {
  // The label 1 has the highest value alone, or the lowest alone: the best split would leave one sample.
  for (const bool is_highest : {true, false}) {
    const std::vector<std::uint8_t> labels{0, 0, 0, 0, 0, 0, 1};
    std::vector<std::uint32_t> samples(labels.size());
    std::iota(samples.begin(), samples.end(), 0U);
    ClassStatistics::Node node;
    ClassStatistics(labels).assign(samples, node);
    std::vector<std::int16_t> values;
    for (const std::uint32_t sample : node.samples()) {
      const int value = sample == 6 ? (is_highest ? 100 : -100) : static_cast<int>(sample);
      values.push_back(static_cast<std::int16_t>(value));
    }
    TreeOptions options;
    options.threshold_bins = 100;
    options.min_leaf_samples = 3;
    ClassStatistics::Scratch scratch;
    const ThresholdSplit found = node.best_split(values, 0, options, scratch);
    const auto left = std::ranges::count_if(samples, [&](std::uint32_t sample) {
      const int value = sample == 6 ? (is_highest ? 100 : -100) : static_cast<int>(sample);
      return value < found.threshold;
    });
    EXPECT_GT(found.gain, 0.0F);
    EXPECT_GE(left, 3);
    EXPECT_LE(left, 4);
  }
}

TEST(ClassStatistics, CandidatesTryDifferentSamplesAsThresholds) {
  std::vector<std::uint8_t> labels(1000);
  std::vector<std::uint32_t> samples(1000);
  std::iota(samples.begin(), samples.end(), 0U);
  for (std::size_t i = 0; i < 1000; ++i) labels[i] = i < 500 ? 0 : 1;
  ClassStatistics::Node node;
  ClassStatistics(labels).assign(samples, node);
  std::vector<std::int16_t> values;
  for (const std::uint32_t sample : node.samples()) values.push_back(static_cast<std::int16_t>(sample));
  TreeOptions options;
  options.threshold_bins = 5;
  std::set<int> thresholds;
  ClassStatistics::Scratch scratch;
  for (std::size_t candidate = 0; candidate < 250; ++candidate) {
    thresholds.insert(node.best_split(values, candidate, options, scratch).threshold);
  }
  EXPECT_EQ(thresholds.size(), 250U);
}

TEST(ClassStatistics, KnowsPureNodes) {
  const std::vector<std::uint8_t> labels{0, 1, 1, 0, 1};
  const ClassStatistics statistics(labels);
  ClassStatistics::Node node;
  statistics.assign(std::vector<std::uint32_t>{1, 2, 4}, node);
  EXPECT_TRUE(node.is_pure());
  statistics.assign(std::vector<std::uint32_t>{0, 3}, node);
  EXPECT_TRUE(node.is_pure());
  statistics.assign(std::vector<std::uint32_t>{0, 4}, node);
  EXPECT_FALSE(node.is_pure());
}

/// Every candidate, every threshold, the definition.
TEST(ClassStatistics, SearchFindsTheBestSplitOfAll) {
  const PixelSamples images = samples_of(ball_scenes(3));
  const ArrangedSamples all = arranged(images);
  const OffsetFeatures features(images, all, {.offsets_per_node = 12});
  std::vector<std::uint32_t> node;
  for (std::uint32_t i = 0; i < all.samples.size(); i += 3) node.push_back(i);
  TreeOptions options;
  options.splits_per_node = 60;
  options.min_leaf_samples = 4;
  options.threshold_bins = 256;  // more than there are samples
  ASSERT_LT(node.size(), 255U);
  SplitSearch<OffsetFeatures, ClassStatistics> search;
  Random random(5);
  const auto found =
      search.best_split(features, ClassStatistics(all.labels), node, options, random, serial_for);

  Random again(5);
  OffsetFeatures::Block block;
  features.begin_node(again, options, block);
  std::vector<std::uint8_t> labels;
  for (const std::uint32_t sample : node) labels.push_back(all.labels[sample]);
  double best = 0.0;
  for (int i = 0; i < options.splits_per_node; ++i) {
    const OffsetPair pair = OffsetFeatures::feature(block, features.draw(again, i, 60, block));
    std::vector<std::int16_t> values;
    for (const std::uint32_t sample : node) values.push_back(features.value(sample, pair));
    for (const std::int16_t threshold : values) {
      best = std::max(best, impurity_reduction(values, labels, threshold, options.min_leaf_samples));
    }
    if (pair == found.feature) {
      const double gain = impurity_reduction(values, labels, found.threshold, options.min_leaf_samples);
      EXPECT_NEAR(found.gain, gain, 1e-5 * gain);
    }
  }
  EXPECT_GT(best, 0.0);
  EXPECT_NEAR(found.gain, best, 1e-5 * best);
}

}  // namespace
}  // namespace knuckle
