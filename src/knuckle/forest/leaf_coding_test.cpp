// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/leaf_coding.h"

#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/forest/forest_testing.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/regression_forest.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr int kTargets = 5;

/// Leaves that vary much along one direction and little along the others.
LeafTable stretched_leaves(int count) {
  Random random(3);
  std::vector<float> values;
  for (int i = 0; i < count; ++i) {
    const double along = random.normal();
    for (int d = 0; d < kTargets; ++d) {
      values.push_back(static_cast<float>(0.5 * d + (d + 1) * along + 0.01 * random.normal()));
    }
  }
  return {kTargets, values, 32};
}

double root_mean_square_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(double{a[i]} - double{b[i]}, 2.0);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST(LeafCoding, IsOffByAStepOverTheRootOfTwelve) {
  const LeafTable leaves = stretched_leaves(4000);
  for (const float step : {0.002f, 0.005f}) {
    const CodedLeaves codes = coded(leaves, {step, std::vector<float>(kTargets, 1.0f)});
    EXPECT_NEAR(root_mean_square_difference(decoded(codes, "a"), leaves.decoded()), step / std::sqrt(12.0),
                0.1 * step);
  }
}

TEST(LeafCoding, NarrowComponentsTakeNoRoom) {
  const LeafTable leaves = stretched_leaves(1000);
  const CodedLeaves codes = coded(leaves, {0.2f, std::vector<float>(kTargets, 1.0f)});
  for (std::size_t i = 1000; i < codes.codes.size(); ++i) EXPECT_EQ(codes.codes[i], 0) << "all but the first";
}

TEST(LeafCoding, AScaledTargetIsKeptThatMuchCoarser) {
  const LeafTable leaves = stretched_leaves(4000);
  std::vector<float> scale(kTargets, 1.0f);
  scale[4] = 0.1f;
  const std::vector<float> back = decoded(coded(leaves, {0.004f, scale}), "a");
  const std::vector<float> values = leaves.decoded();
  double first = 0.0;
  double last = 0.0;
  for (std::size_t i = 0; i < values.size(); i += kTargets) {
    first += std::pow(back[i] - values[i], 2.0);
    last += std::pow(back[i + 4] - values[i + 4], 2.0);
  }
  EXPECT_NEAR(std::sqrt(last / first), 10.0, 1.5);
}

TEST(LeafCoding, AForestsFileHoldsIt) {
  const testing::RandomRows rows(300, 12, kTargets);
  RegressionForestOptions options;
  options.trees = 2;
  options.tree.splits_per_node = 20;
  const RegressionForest forest = train_regression_forest(rows.samples(), options);
  const RegressionForest back = read_forest(testing::written_model([&](ModelWriter& file) {
    write_forest(file, forest, LeafCoding{0.001f, std::vector<float>(kTargets, 1.0f)});
  }));
  constexpr double kOneOf8Bits = 12.0 / 255.0;
  for (const auto& features : rows.features) {
    const auto expected = forest.predict(features).mean;
    const auto actual = back.predict(features).mean;
    for (int d = 0; d < kTargets; ++d) EXPECT_NEAR(actual[d], expected[d], kOneOf8Bits);
  }
}

TEST(LeafCoding, RefusesWhatDoesNotFit) {
  const LeafTable leaves = stretched_leaves(10);
  const std::vector<float> ones(kTargets, 1.0f);
  EXPECT_THAT(error_of([&] { coded(leaves, {0.1f, {1.0f}}); }), HasSubstr("1 scales for 5 targets"));
  EXPECT_THAT(error_of([&] { coded(leaves, {0.0f, ones}); }), HasSubstr("a step of 0, expected more than 0"));
  EXPECT_THAT(error_of([&] { coded(leaves, {1e-9f, ones}); }), HasSubstr("too fine"));
  const CodedLeaves good = coded(leaves, {0.1f, ones});
  CodedLeaves bad = good;
  bad.components.pop_back();
  EXPECT_THAT(error_of([&] { decoded(bad, "a.model"); }), HasSubstr("a.model: the parts"));
  bad = good;
  bad.mean[0] = NAN;
  EXPECT_THAT(error_of([&] { decoded(bad, "a.model"); }), HasSubstr("not finite"));
  bad = good;
  bad.scale[1] = 0.0f;
  EXPECT_THAT(error_of([&] { decoded(bad, "a.model"); }), HasSubstr("a scale is not above 0"));
  bad = good;
  bad.scale[1] = 1e-38f;  // each part is finite, what it makes is not
  bad.mean[1] = 1e30f;
  EXPECT_THAT(error_of([&] { decoded(bad, "a.model"); }), HasSubstr("a leaf value is not finite"));
  bad.scale[1] = 1e-38f;  // each part is finite, the quotient is not
  bad.mean[1] = 1e30f;
  EXPECT_THAT(error_of([&] { decoded(bad, "a.model"); }), HasSubstr("a.model: a leaf value is not finite"));
}

}  // namespace
}  // namespace knuckle
