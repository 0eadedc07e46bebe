// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/significance.h"

#include <cmath>
#include <limits>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr double kMissing = std::numeric_limits<double>::infinity();

MethodScore with_errors(std::vector<double> errors) {
  MethodScore score;
  score.frame_mean_3d_mm = std::move(errors);
  return score;
}

/// Errors of two methods that differ by `shift` on average and by noise, which keeps a part of itself from
/// frame to frame.
std::pair<MethodScore, MethodScore> noisy_pair(int frames, double shift, double kept, std::uint64_t stream) {
  Random random(5, stream);
  std::vector<double> first;
  std::vector<double> second;
  double noise = random.normal();
  for (int i = 0; i < frames; ++i) {
    noise = kept * noise + std::sqrt(1.0 - kept * kept) * random.normal();
    const double both = 10.0 + 3.0 * random.normal();  // a frame that is hard is hard for both
    first.push_back(both + shift + noise);
    second.push_back(both);
  }
  return {with_errors(first), with_errors(second)};
}

/// Part of many experiments whose interval holds the true difference, and part that is called significant.
std::pair<double, double> covered_and_significant(int frames, double shift, double kept) {
  constexpr int kExperiments = 400;
  int covered = 0;
  int significant = 0;
  for (int i = 0; i < kExperiments; ++i) {
    const auto [first, second] = noisy_pair(frames, shift, kept, static_cast<std::uint64_t>(i));
    const MethodDifference found = difference(first, second);
    covered += found.low_mm <= shift && shift <= found.high_mm ? 1 : 0;
    significant += found.p_value < 0.05 ? 1 : 0;
  }
  return {covered / double{kExperiments}, significant / double{kExperiments}};
}

TEST(DifferenceTest, ItsIntervalHoldsTheTruthAsOftenAsItSays) {
  const auto [covered, significant] = covered_and_significant(120, 0.0, 0.0);
  EXPECT_NEAR(covered, 0.95, 0.03);
  EXPECT_NEAR(significant, 0.05, 0.03);
}

TEST(DifferenceTest, FramesThatAreAlikeDoNotMakeItTooSure) {
  // Single frames drawn would hold the truth in 49 % of such experiments: sqrt((1 - 0.8) / (1 + 0.8)) = 1/3.
  EXPECT_GT(covered_and_significant(600, 0.0, 0.8).first, 0.89);
}

TEST(DifferenceTest, FindsASmallDifferenceBehindLargeErrors) {
  // A tenth of the noise of the pair, a thirtieth of that of a frame, in 2,000 frames.
  const auto [covered, significant] = covered_and_significant(2000, 0.1, 0.0);
  EXPECT_GT(significant, 0.95);
  EXPECT_NEAR(covered, 0.95, 0.04);
}

TEST(DifferenceTest, OfEqualMethodsIsNothing) {
  const MethodScore one = with_errors({3, 1, 4, 1, 5, 9});
  const MethodDifference found = difference(one, one);
  EXPECT_EQ(found.frames, 6);
  EXPECT_EQ(found.mean_mm, 0.0);
  EXPECT_EQ(found.low_mm, 0.0);
  EXPECT_EQ(found.high_mm, 0.0);
  EXPECT_EQ(found.p_value, 1.0);
}

TEST(DifferenceTest, LooksAtFramesThatBothHave) {
  const MethodScore first = with_errors({5, kMissing, 7, 9, kNaN, 6});
  const MethodScore second = with_errors({2, 3, kMissing, 5, kNaN, 2});
  const MethodDifference found = difference(first, second);
  EXPECT_EQ(found.frames, 3);
  EXPECT_NEAR(found.mean_mm, (3.0 + 4.0 + 4.0) / 3.0, 1e-12);
  EXPECT_GE(found.low_mm, 3.0);
  EXPECT_LE(found.high_mm, 4.0);
  const MethodDifference other_way = difference(second, first);
  EXPECT_NEAR(other_way.mean_mm, -found.mean_mm, 1e-12);
  EXPECT_LT(other_way.high_mm, 0.0);
}

TEST(DifferenceTest, OfTooFewFramesIsNotKnown) {
  const MethodDifference found = difference(with_errors({1, kMissing}), with_errors({2, 2}));
  EXPECT_EQ(found.frames, 1);
  EXPECT_TRUE(std::isnan(found.mean_mm));
  EXPECT_TRUE(std::isnan(found.p_value));
}

TEST(DifferencesTest, AreOfAllPairsOrOfTheBestWithAll) {
  std::vector<MethodScore> methods;
  for (const double error : {4.0, 3.0, 5.0}) {
    methods.push_back(with_errors({error, error}));
    methods.back().mean_3d_mm = error;
  }
  std::vector<MethodDifference> found = differences(methods);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[1].first, 0u);
  EXPECT_EQ(found[1].second, 2u);
  EXPECT_EQ(found[1].mean_mm, -1.0);
  for (int i = 0; i < 4; ++i) methods.push_back(methods.back());
  found = differences(methods);
  ASSERT_EQ(found.size(), 6u);
  EXPECT_EQ(found[0].first, 1u);
  EXPECT_EQ(found[0].second, 0u);
  EXPECT_EQ(found[5].second, 6u);
}

}  // namespace
}  // namespace knuckle
