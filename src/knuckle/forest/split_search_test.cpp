// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/split_search.h"

#include <cmath>
#include <numeric>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/pixel_pairs.h"

namespace knuckle {
namespace {

using testing::RandomRows;

TEST(ValueBins, ThresholdsPartValuesExactlyAsBinsDo) {
  Random random(3);
  for (const int range : {1, 2, 5, 31, 32, 33, 100, 4096, 65533}) {
    std::vector<std::int16_t> values;
    for (int i = 0; i < 500; ++i) {
      values.push_back(static_cast<std::int16_t>(
          -32766 + static_cast<int>(random.below(static_cast<std::uint32_t>(range)))));
    }
    const ValueBins parts(values, 32);
    std::vector<std::uint8_t> bins(values.size());
    parts.assign(values, bins.data());
    for (std::size_t i = 0; i < values.size(); ++i) {
      ASSERT_LT(bins[i], parts.count()) << range;
      for (int bin = 1; bin < parts.count(); ++bin) {
        ASSERT_EQ(bins[i] >= bin, values[i] >= parts.first_value(bin)) << "range " << range << " bin " << bin;
      }
    }
  }
}

TEST(ValueBins, AreOfEqualWidth) {
  std::vector<std::int16_t> values(3200);
  std::iota(values.begin(), values.end(), static_cast<std::int16_t>(-1000));
  const ValueBins parts(values, 32);
  for (int bin = 0; bin < 32; ++bin) EXPECT_NEAR(parts.first_value(bin), -1000 + 100 * bin, 2) << bin;
}

TEST(PixelPairs, BlockHoldsTheValuesOfItsSamples) {
  const RandomRows rows(45, 70, 1);
  const TrainingSamples samples = rows.samples();
  const PixelPairFeatures features(samples);
  const std::vector<std::uint32_t> some{4, 44, 0, 17, 30, 31, 32, 33, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12};
  PixelPairFeatures::Block block;
  features.gather(some, serial_for, block);
  Random random(1);
  std::vector<std::int16_t> values(some.size());
  std::set<int> first_pixels;
  for (int i = 0; i < 140; ++i) {
    const PixelPair pair = features.draw(random, i, 140);
    ASSERT_LT(pair.first, 70);
    ASSERT_LT(pair.second, 70);
    first_pixels.insert(pair.first);
    PixelPairFeatures::values(block, pair, values.data());
    for (std::size_t s = 0; s < some.size(); ++s) ASSERT_EQ(values[s], features.value(some[s], pair));
  }
  EXPECT_EQ(first_pixels.size(), 70U);  // two candidates a pixel, by stratification
}

/// The reduction of the sum of squared distances to the mean, in double, from its definition.
double variance_reduction(const ScoringTargets& targets, const std::vector<std::uint32_t>& left,
                          const std::vector<std::uint32_t>& right) {
  const auto sum_of_squares = [&](const std::vector<std::uint32_t>& samples) {
    double total = 0.0;
    for (int d = 0; d < targets.dimensions; ++d) {
      double mean = 0.0;
      for (const std::uint32_t s : samples) mean += targets.row(s)[d];
      mean /= static_cast<double>(samples.size());
      for (const std::uint32_t s : samples) total += std::pow(targets.row(s)[d] - mean, 2.0);
    }
    return total;
  };
  std::vector<std::uint32_t> all = left;
  all.insert(all.end(), right.begin(), right.end());
  return sum_of_squares(all) - sum_of_squares(left) - sum_of_squares(right);
}

/// The best split by brute force: every candidate, every threshold, the definition.
template <int kLanes>
void expect_best_split(int sample_count, int target_count, int min_leaf_samples) {
  const RandomRows rows(sample_count, 40, target_count);
  const TrainingSamples samples = rows.samples();
  const auto order = samples.canonical_order().indices;
  const ScoringTargets targets = make_scoring_targets(samples, {order}, {}, kLanes - 1);
  TreeOptions options;
  options.splits_per_node = 60;
  options.min_leaf_samples = min_leaf_samples;
  const PixelPairFeatures features(samples);
  SplitSearch<PixelPairFeatures, VarianceStatistics<kLanes>> search;
  Random random(5);
  const auto found =
      search.best_split(features, VarianceStatistics<kLanes>(targets), order, options, random, serial_for);

  Random again(5);
  double best = 0.0;
  for (int i = 0; i < options.splits_per_node; ++i) {
    const PixelPair pair = features.draw(again, i, options.splits_per_node);
    std::vector<std::int16_t> values;
    for (const std::uint32_t s : order) values.push_back(features.value(s, pair));
    const ValueBins parts(values, bins_for(options, order.size()));
    for (int bin = 1; bin < parts.count(); ++bin) {
      std::vector<std::uint32_t> side[2];
      for (std::size_t s = 0; s < order.size(); ++s)
        side[values[s] >= parts.first_value(bin) ? 1 : 0].push_back(order[s]);
      if (std::ssize(side[0]) < min_leaf_samples || std::ssize(side[1]) < min_leaf_samples) continue;
      const double gain = variance_reduction(targets, side[0], side[1]);
      best = std::max(best, gain);
      if (pair == found.feature && parts.first_value(bin) == found.threshold) {
        EXPECT_NEAR(found.gain, gain, 1e-5 * gain);
      }
    }
  }
  EXPECT_GT(best, 0.0);
  EXPECT_NEAR(found.gain, best, 1e-5 * best);
}

TEST(SplitSearch, FindsTheSplitOfGreatestVarianceReduction) {
  expect_best_split<8>(200, 1, 1);
  expect_best_split<8>(100, 7, 5);
  expect_best_split<16>(150, 15, 20);
  expect_best_split<32>(37, 25, 1);
  expect_best_split<96>(64, 66, 3);
  expect_best_split<16>(2, 4, 1);
}

TEST(SplitSearch, FindsNoneWhereTargetsAreEqual) {
  RandomRows rows(64, 10, 3);
  for (auto& target : rows.targets) target = {1.5F, -0.3F, 7.0F};
  rows.targets.push_back({5.0F, 5.0F, 5.0F});  // outside the node, so that the whole set is not constant
  rows.features.push_back(rows.features[0]);
  const TrainingSamples samples = rows.samples();
  std::vector<std::uint32_t> node(64);
  std::iota(node.begin(), node.end(), 0U);
  const auto order = samples.canonical_order().indices;
  const ScoringTargets targets = make_scoring_targets(samples, {order}, {}, 7);
  SplitSearch<PixelPairFeatures, VarianceStatistics<8>> search;
  Random random(1);
  EXPECT_EQ(search
                .best_split(PixelPairFeatures(samples), VarianceStatistics<8>(targets), node, {}, random,
                            serial_for)
                .gain,
            0.0F);
}

}  // namespace
}  // namespace knuckle
