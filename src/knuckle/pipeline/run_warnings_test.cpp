// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/run_warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Frame frame_at(float depth_mm) {
  Frame frame;
  frame.camera = {.width = 64, .height = 48, .fx = 47.5, .fy = 47.0, .cx = 31.0, .cy = 25.0};
  frame.depth_mm = Image<float>(64, 48, depth_mm);
  return frame;
}

FrameEstimate hand_at(double distance_mm) {
  FrameEstimate estimate;
  estimate.hands.resize(1);
  estimate.hands[0].region.centre = Point3(10.0, 20.0, distance_mm);
  return estimate;
}

FrameEstimate no_hand() {
  FrameEstimate estimate;
  estimate.status = "no surface was measured in the frame";
  return estimate;
}

TEST(RunWarnings, SayNothingWhereAllIsWell) {
  RunWarnings warnings;
  EXPECT_THAT(warnings.messages(), IsEmpty());
  for (int i = 0; i < 5; ++i) warnings.add(frame_at(700.0f), hand_at(100.0 + 725.0 * i));  // 0.1 to 3 m
  for (int i = 0; i < 5; ++i) warnings.add(frame_at(0.0f), no_hand());  // half of the frames
  EXPECT_THAT(warnings.messages(), IsEmpty());
}

TEST(RunWarnings, TellHandsThatAreTooNearOrTooFar) {
  RunWarnings near;
  near.add(frame_at(500.0f), hand_at(500.0));
  near.add(frame_at(500.0f), hand_at(52.0));
  EXPECT_THAT(near.messages(), IsEmpty());  // not in most frames
  near.add(frame_at(500.0f), hand_at(48.0));
  EXPECT_THAT(near.messages(), ElementsAre(AllOf(HasSubstr("2 of 3 frames"), HasSubstr("0.05 m"),
                                                 HasSubstr("depth_unit_mm"))));
  RunWarnings far;
  far.add(frame_at(500.0f), hand_at(4980.0));
  EXPECT_THAT(far.messages(), ElementsAre(AllOf(HasSubstr("1 of 1 frames"), HasSubstr("4.98 m"))));
  far.add(frame_at(500.0f), hand_at(500.0));
  EXPECT_THAT(far.messages(), IsEmpty());  // not in most frames
}

TEST(RunWarnings, TellAWrongUnitAlsoWhereItHidesAllHands) {
  RunWarnings warnings;
  Frame frame = frame_at(20000.0f);
  for (int row = 10; row < 30; ++row) {
    for (int column = 5; column < 30; ++column) frame.depth_mm(column, row) = 6000.0f;
  }
  warnings.add(frame, no_hand());
  EXPECT_THAT(warnings.messages(),
              ElementsAre(HasSubstr("6.00 m"), HasSubstr("no sure hand in 1 of 1 frames")));
}

TEST(RunWarnings, TellAPrincipalPointThatIsFarOff) {
  RunWarnings off;
  Frame frame = frame_at(500.0f);
  frame.camera.cy = 3.0;
  off.add(frame, hand_at(500.0));
  EXPECT_THAT(off.messages(), ElementsAre(AllOf(HasSubstr("cx 31.0, cy 3.0"), HasSubstr("64 x 48 px"),
                                                HasSubstr("another resolution"))));
  RunWarnings exchanged;
  std::swap(frame.camera.fx, frame.camera.cx);
  std::swap(frame.camera.fy, frame.camera.cy);
  exchanged.add(frame, hand_at(500.0));
  EXPECT_THAT(exchanged.messages(), ElementsAre(HasSubstr("fx and cx are probably exchanged")));
  RunWarnings orthographic;
  frame.camera.model = CameraModel::orthographic;
  orthographic.add(frame, hand_at(500.0));
  EXPECT_THAT(orthographic.messages(), IsEmpty());
}

TEST(RunWarnings, TellThatMostFramesAreUnsure) {
  RunWarnings warnings;
  FrameEstimate unsure = hand_at(500.0);
  unsure.status = kUnsure;
  warnings.add(frame_at(500.0f), unsure);
  warnings.add(frame_at(500.0f), hand_at(500.0));
  EXPECT_THAT(warnings.messages(), IsEmpty());
  warnings.add(frame_at(500.0f), unsure);
  EXPECT_THAT(warnings.messages(), ElementsAre(AllOf(HasSubstr("no sure hand in 2 of 3 frames"),
                                                     HasSubstr("left hand"), HasSubstr("intrinsics"))));
}

}  // namespace
}  // namespace knuckle
