// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/training_samples.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/scoring_targets.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::RandomRows;

TEST(FeatureQuantizer, LosesAtMostHalfAStepAndClips) {
  const FeatureQuantizer quantized{0.01F};
  for (const float value : {-3.0F, -0.004F, 0.0F, 0.0061F, 1.234F, 150.0F}) {
    EXPECT_NEAR(static_cast<float>(quantized(value)) * 0.01F, value, 0.0051F);
  }
  EXPECT_EQ(quantized(1e9F), FeatureQuantizer::kLargest);
  EXPECT_EQ(quantized(-1e9F), -FeatureQuantizer::kLargest);
  EXPECT_EQ(quantized(std::nanf("")), -FeatureQuantizer::kLargest);
}

TEST(TrainingSamples, RefusesWhatCannotBeLearned) {
  TrainingSamples samples(3, 2, 1);
  const std::vector<float> features{1.0F, 2.0F};
  const std::vector<float> targets{1.0F};
  const std::vector<float> none{std::nanf("")};
  const std::vector<float> infinite{1.0F, INFINITY};
  EXPECT_THAT(error_of([&] { samples.set(3, features, targets); }), HasSubstr("there is room for 3"));
  EXPECT_THAT(error_of([&] { samples.set(0, targets, targets); }), HasSubstr("expected 2 and 1"));
  EXPECT_THAT(error_of([&] { samples.set(1, features, none); }),
              AllOf(HasSubstr("sample 1"), HasSubstr("target 0")));
  EXPECT_THAT(error_of([&] { samples.set(2, infinite, targets); }),
              AllOf(HasSubstr("feature 1"), HasSubstr("inf")));
  EXPECT_EQ(samples.set_count(), 0);
  samples.set(2, features, targets);
  EXPECT_EQ(samples.set_count(), 1);
  EXPECT_THAT(error_of([] { TrainingSamples(-1, 2, 1); }),
              HasSubstr("count is -1, expected [0, 4294967295]"));
  EXPECT_THAT(error_of([] { TrainingSamples(3, 0, 1); }), HasSubstr("0 features, expected [1, 65535]"));
  EXPECT_THAT(error_of([] { TrainingSamples(3, 65536, 1); }), HasSubstr("65536 features"));
  EXPECT_THAT(error_of([] { TrainingSamples(3, 2, 0); }), HasSubstr("0 targets, expected at least 1"));
  EXPECT_TRUE(samples.is_set(2));
}

TEST(TrainingSamples, RefuseSizesThatAreOutOfRange) {
  EXPECT_THAT(error_of([] { TrainingSamples(-1, 2, 1); }), HasSubstr("count is -1"));
  EXPECT_THAT(error_of([] { TrainingSamples(std::int64_t{1} << 32, 2, 1); }),
              HasSubstr("count is 4294967296"));
  EXPECT_THAT(error_of([] { TrainingSamples(1, 0, 1); }), HasSubstr("0 features, expected [1, 65535]"));
  EXPECT_THAT(error_of([] { TrainingSamples(1, 65536, 1); }), HasSubstr("65536 features"));
  EXPECT_THAT(error_of([] { TrainingSamples(1, 2, 0); }), HasSubstr("0 targets"));
}

TEST(TrainingSamples, CanonicalOrderFollowsContents) {
  const RandomRows rows(50, 9, 3);
  std::vector<std::int64_t> place(50);
  std::iota(place.rbegin(), place.rend(), 0);
  const TrainingSamples forward = rows.samples();
  const TrainingSamples backward = rows.samples_at(place);
  const auto a = forward.canonical_order();
  const auto b = backward.canonical_order();
  ASSERT_EQ(a.indices.size(), 50U);
  EXPECT_EQ(a.hash, b.hash);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(a.indices[i], 49 - b.indices[i]);

  RandomRows changed = rows;
  changed.targets[20][1] += 1e-4F;
  EXPECT_NE(changed.samples().canonical_order().hash, a.hash);
}

TEST(ScoringTargets, KeepDistancesWhereAllDimensionsFit) {
  const RandomRows rows(40, 6, 5);
  const TrainingSamples samples = rows.samples();
  const ScoringTargets scoring = make_scoring_targets(samples, {samples.canonical_order().indices}, {}, 7);
  ASSERT_EQ(scoring.dimensions, 5);
  for (std::size_t d = 0; d < 5; ++d) {
    const float truth = rows.targets[3][d] - rows.targets[17][d];
    const float kept = scoring.step * static_cast<float>(scoring.row(3)[d] - scoring.row(17)[d]);
    EXPECT_NEAR(kept, truth, 1.1F * scoring.step);
  }
}

TEST(ScoringTargets, ProjectionKeepsTheVarianceOfTargetsInASubspace) {
  RandomRows rows(200, 6, 9);
  for (auto& target : rows.targets) {  // 9 targets of 3 degrees of freedom
    for (std::size_t d = 3; d < 9; ++d) target[d] = target[d % 3] * (d < 6 ? -2.0F : 0.5F);
  }
  const TrainingSamples samples = rows.samples();
  const auto order = samples.canonical_order().indices;
  const ScoringTargets scoring = make_scoring_targets(samples, {order}, {}, 3);
  ASSERT_EQ(scoring.dimensions, 3);
  EXPECT_NEAR(scoring.captured_variance, 1.0, 1e-9);
  double truth = 0.0;
  double kept = 0.0;
  for (std::size_t d = 0; d < 9; ++d) truth += std::pow(rows.targets[5][d] - rows.targets[80][d], 2.0);
  for (std::size_t d = 0; d < 3; ++d)
    kept += std::pow(scoring.step * (scoring.row(5)[d] - scoring.row(80)[d]), 2.0);
  EXPECT_NEAR(kept, truth, 0.01 * truth);
  EXPECT_LT(make_scoring_targets(samples, {order}, {}, 1).captured_variance, 0.99);
}

TEST(ScoringTargets, WeightsScaleTargets) {
  const RandomRows rows(40, 6, 2);
  const TrainingSamples samples = rows.samples();
  const auto order = samples.canonical_order().indices;
  const std::vector<double> weights{1.0, 0.0};
  const ScoringTargets scoring = make_scoring_targets(samples, {order}, weights, 7);
  for (std::size_t i = 0; i < 40; ++i) EXPECT_EQ(scoring.row(i)[1], 0);
  const std::vector<double> wrong{1.0};
  EXPECT_THAT(error_of([&] { make_scoring_targets(samples, {order}, wrong, 7); }),
              HasSubstr("1 target weights"));
  const std::vector<double> negative{1.0, -0.5};
  EXPECT_THAT(error_of([&] { make_scoring_targets(samples, {order}, negative, 7); }),
              HasSubstr("target weight -0.5 is not in [0, inf)"));
  const std::vector<double> infinite{1.0, INFINITY};
  EXPECT_THAT(error_of([&] { make_scoring_targets(samples, {order}, infinite, 7); }),
              HasSubstr("target weight inf is not in [0, inf)"));
}

}  // namespace
}  // namespace knuckle
