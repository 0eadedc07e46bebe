// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_skin.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

using testing::bent_hand_points;
using testing::flesh_frame;
using testing::kLabelCamera;
using testing::LandmarkPoints;
using testing::pose_of_points;

std::size_t at(Landmark landmark) {
  return static_cast<std::size_t>(landmark);
}

TEST(LabelSkin, ALandmarkOnAPixelLiesBelowItsSkin) {
  const LandmarkPoints truth = bent_hand_points(0.0);
  const Frame frame = flesh_frame(truth);
  const double palm = (truth[at(Landmark::middle_mcp)] - truth[at(Landmark::wrist)]).norm();
  for (const Landmark landmark : {Landmark::index_pip, Landmark::middle_dip, Landmark::ring_mcp}) {
    const ImagePoint seen = pose_of_points(truth).joints[at(landmark)];
    const ImagePoint placed = placed_on_pixel(frame, seen.u, seen.v, landmark, palm, 0.0);
    EXPECT_NEAR(placed.depth_mm, seen.depth_mm, 7.0) << name_of(landmark);
    EXPECT_EQ(placed.u, seen.u);
  }
}

TEST(LabelSkin, WhoPointsBesideAFingerDoesNotGetTheWall) {
  const LandmarkPoints truth = bent_hand_points(0.0);
  const Frame frame = flesh_frame(truth);
  const std::vector<ImagePoint> joints = pose_of_points(truth).joints;
  const ImagePoint tip = joints[at(Landmark::middle_tip)];
  ImagePoint beside = tip;
  while (frame.depth_mm(static_cast<int>(std::lround(beside.u)), static_cast<int>(std::lround(beside.v))) <
         800.0f)
    beside.v -= 0.5;
  const double palm = (truth[at(Landmark::middle_mcp)] - truth[at(Landmark::wrist)]).norm();
  const ImagePoint placed =
      placed_on_pixel(frame, beside.u, beside.v, Landmark::middle_tip, palm, kNaN, skin_depths(joints));
  EXPECT_NEAR(placed.depth_mm, tip.depth_mm, 20.0);
  EXPECT_EQ(placed.v, beside.v);
  EXPECT_FALSE(skin_depth_at(frame, 5, 5, skin_depths(joints))) << "there is the wall alone";
  EXPECT_NEAR(*skin_depth_at(frame, 5, 5, {}), 900.0, 1e-3);
}

TEST(LabelSkin, TheModelSettlesTheDepthTheMoreTheFartherTheMeasurementIsButNeverFarFromIt) {
  EXPECT_EQ(settled_depth_mm(500.0, 500.0), 500.0);
  double last_share = 1.0;
  for (const double apart : {1.0, 10.0, 20.0, 29.0}) {
    const double share =
        1.0 - (settled_depth_mm(500.0, 500.0 + apart) - 500.0) / apart;  // of the measurement
    EXPECT_LT(share, last_share);
    EXPECT_GT(share, 0.0);
    EXPECT_NEAR(settled_depth_mm(500.0, 500.0 - apart), 1000.0 - settled_depth_mm(500.0, 500.0 + apart),
                1e-9);
    last_share = share;
  }
  EXPECT_LT(last_share, 0.5);
  for (const double apart : {40.0, 100.0, 1000.0})
    EXPECT_EQ(settled_depth_mm(500.0, 500.0 - apart), 480.0) << "a model that lies elsewhere is wrong";
}

TEST(LabelSkin, WithoutAMeasurementTheDepthIsKeptOrNothingIsKnown) {
  Frame frame = flesh_frame(bent_hand_points(0.0));
  frame.depth_mm = Image<float>(kLabelCamera.width, kLabelCamera.height);
  EXPECT_EQ(placed_on_pixel(frame, 10, 10, Landmark::wrist, 95, 444).depth_mm, 444);
  EXPECT_TRUE(placed_on_pixel(frame, 10, 10, Landmark::wrist, 95, kNaN).is_missing());
  EXPECT_TRUE(placed_on_pixel(frame, -1e5, 1e5, Landmark::wrist, 95, kNaN).is_missing());
}

}  // namespace
}  // namespace knuckle
