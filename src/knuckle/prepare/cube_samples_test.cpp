// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/cube_samples.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::kTestCentre;
using testing::kTestCropPx;
using testing::kTestCube;
using testing::kTestJoints;

TEST(CubeSamples, TheCropHasThePatchsScale) {
  const CubeSamples samples(1, kTestJoints, kTestCube, kTestCropPx);
  EXPECT_EQ(samples.crop().size_px, 48);
  EXPECT_DOUBLE_EQ(samples.crop().side_mm, 300.0);
}

TEST(CubeSamples, KeepsDepthsToHalfAStepAndBackgroundExactly) {
  const testing::MadeUpHand hand = testing::made_up_hand(0);
  const CubeSamples samples = testing::made_up_samples(1);
  const CubeSample sample = samples.sample(0);
  for (std::size_t i = 0; i < sample.codes.size(); ++i) {
    const float depth = hand.crop.pixels.pixels()[i];
    if (depth == kCubeBackground) {
      EXPECT_EQ(sample.codes[i], CubeSamples::kBackgroundCode);
    } else {
      EXPECT_NEAR(CubeSamples::depth_of_code(sample.codes[i]), depth, 0.5 / 127.0 + 1e-6);
    }
  }
  EXPECT_FLOAT_EQ(CubeSamples::depth_of_code(0), -1.0f);
  EXPECT_FLOAT_EQ(CubeSamples::depth_of_code(254), 1.0f);
  for (std::size_t j = 0; j < hand.joints.size(); ++j) {
    EXPECT_NEAR(sample.joints[3 * j], hand.joints[j].u * 23.5, 1e-5);
    EXPECT_NEAR(sample.joints[3 * j + 1], hand.joints[j].v * 23.5, 1e-5);
    EXPECT_NEAR(sample.joints[3 * j + 2], hand.joints[j].d, 1e-6);
  }
  EXPECT_EQ(sample.centre_mm, kTestCentre);
}

TEST(CubeSamples, ForgetsPlacesThatWereNeverSet) {
  CubeSamples samples(5, kTestJoints, kTestCube, kTestCropPx);
  for (const int i : {4, 1}) {
    testing::MadeUpHand hand = testing::made_up_hand(0);
    hand.joints[0].d = 0.1 * i;
    samples.set(i, hand.crop, hand.joints, kTestCentre);
  }
  samples.finish();
  ASSERT_EQ(samples.size(), 2);
  EXPECT_FLOAT_EQ(samples.sample(0).joints[2], 0.1f);
  EXPECT_FLOAT_EQ(samples.sample(1).joints[2], 0.4f);
}

TEST(CubeSamples, RefusesOtherSizes) {
  EXPECT_THAT(error_of([] { CubeSamples(1, kTestJoints, kTestCube, 31); }),
              HasSubstr("crops of 31 px are smaller than the patches of 32 px"));
  CubeSamples samples(1, kTestJoints, kTestCube, kTestCropPx);
  testing::MadeUpHand hand = testing::made_up_hand(0);
  const std::vector<PatchPoint> few(3);
  EXPECT_THAT(error_of([&] { samples.set(0, hand.crop, few, kTestCentre); }),
              HasSubstr("3 joints, expected 14"));
  hand.crop.pixels = Image<float>(32, 32);
  EXPECT_THAT(error_of([&] { samples.set(0, hand.crop, hand.joints, kTestCentre); }),
              HasSubstr("a crop of 32 x 32, expected 48 x 48"));
}

TEST(CubeSamples, TakesThoseOfOthersAndRefusesOtherSizes) {
  const CubeSamples from = testing::made_up_samples(2);
  CubeSamples to(1, kTestJoints, kTestCube, kTestCropPx);
  to.set(0, from.sample(1));
  to.finish();
  EXPECT_TRUE(std::ranges::equal(to.sample(0).codes, from.sample(1).codes));
  EXPECT_TRUE(std::ranges::equal(to.sample(0).joints, from.sample(1).joints));
  EXPECT_EQ(to.sample(0).centre_mm, from.sample(1).centre_mm);
  CubeSamples larger(1, kTestJoints, kTestCube, kTestCropPx + 1);
  EXPECT_THAT(error_of([&] { larger.set(0, from.sample(0)); }), HasSubstr("pixels"));
}

}  // namespace
}  // namespace knuckle
