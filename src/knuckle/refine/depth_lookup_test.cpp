// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/depth_lookup.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// 40 x 30 pixels of depth 500 + column; the hand is the box (10, 5) to (29, 24) but for its first row.
class DepthLookupTest : public ::testing::Test {
 protected:
  DepthLookupTest() {
    frame_.depth_mm = Image<float>(40, 30);
    for (int row = 0; row < 30; ++row) {
      for (int column = 0; column < 40; ++column)
        frame_.depth_mm(column, row) = 500.0f + static_cast<float>(column);
    }
    hand_.box = Box{10, 5, 20, 20};
    hand_.mask = Image<std::uint8_t>(20, 20, 1);
    std::ranges::fill(hand_.mask.row(0), std::uint8_t{0});
  }

  std::vector<double> depths_of(std::vector<ImagePoint> joints, DepthLookupOptions options = {}) const {
    HandPose pose = HandPose::missing(convention_from_name("icg20"));
    std::ranges::copy(joints, pose.joints.begin());
    const HandPose refined = DepthLookup(options).refine(frame_, hand_, pose).pose;
    std::vector<double> depths;
    for (std::size_t i = 0; i < joints.size(); ++i) {
      EXPECT_THAT(refined.joints[i].u, ::testing::NanSensitiveDoubleEq(joints[i].u));
      depths.push_back(refined.joints[i].depth_mm);
    }
    for (std::size_t i = joints.size(); i < refined.joints.size(); ++i)
      EXPECT_TRUE(refined.joints[i].is_missing());
    return depths;
  }

  Frame frame_;
  HandRegion hand_;
};

using ::testing::ElementsAre;
using ::testing::NanSensitiveDoubleEq;

TEST_F(DepthLookupTest, TakesTheDepthOfTheNearestPixel) {
  EXPECT_THAT(depths_of({{12.4, 10, 900}, {12.6, 10, 900}, {28.9, 23.6, 0}}), ElementsAre(512, 513, 529));
}

TEST_F(DepthLookupTest, FillsADepthThatTheMethodDoesNotInfer) {
  EXPECT_THAT(depths_of({{12, 10, kNaN}, {35, 10, kNaN}}), ElementsAre(512, 512));
}

TEST_F(DepthLookupTest, GivesBackgroundTheMedianOfTheOthers) {
  frame_.depth_mm(20, 10) = 0.0f;
  frame_.depth_mm(21, 10) = std::numeric_limits<float>::quiet_NaN();
  const std::vector<ImagePoint> joints = {{12, 10, 1}, {13, 10, 1}, {29, 10, 1},  // on the hand
                                          {20, 10, 1}, {21, 10, 1},               // no measurement
                                          {12, 5, 1},  {35, 10, 1},  // not in the mask, not in the box
                                          {-4, 10, 1}, {12, 31, 1}, {1e300, 10, 1}};  // outside of the image
  EXPECT_THAT(depths_of(joints), ElementsAre(512, 513, 529, 513, 513, 513, 513, 513, 513, 513));
}

TEST_F(DepthLookupTest, TakesTheMeanOfTheMiddleTwoOfAnEvenNumber) {
  EXPECT_THAT(depths_of({{12, 10, 1}, {15, 10, 1}, {0, 0, 1}}), ElementsAre(512, 515, 513.5));
}

TEST_F(DepthLookupTest, KeepsThePoseWhereNoJointIsOnTheHand) {
  EXPECT_THAT(depths_of({{0, 0, 700}, {39, 29, 710}}), ElementsAre(700, 710));
  hand_ = HandRegion{};
  EXPECT_THAT(depths_of({{12, 10, 700}}), ElementsAre(700));
}

TEST_F(DepthLookupTest, LeavesMissingJointsMissing) {
  EXPECT_THAT(depths_of({{12, 10, 1}, {kNaN, kNaN, kNaN}}), ElementsAre(512, NanSensitiveDoubleEq(kNaN)));
}

TEST_F(DepthLookupTest, PutsJointsBehindTheSkinWhereAsked) {
  EXPECT_THAT(depths_of({{12, 10, 1}, {0, 0, 1}}, {8.0}), ElementsAre(520, 520));
  EXPECT_THAT(testing::error_of([] { DepthLookup lookup({-1.0}); }),
              ::testing::HasSubstr("surface_offset_mm"));
}

}  // namespace
}  // namespace knuckle
