// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/defined_pose.h"

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

Projection some_projection(CameraModel model = CameraModel::projective) {
  Camera camera;
  camera.model = model;
  camera.width = 320;
  camera.height = 240;
  camera.fx = 250;
  camera.fy = 255;
  camera.cx = 160;
  camera.cy = 118;
  return Projection(camera);
}

HandPose straight_hand(const Projection& projection, double depth_mm = 600.0) {
  RigidTransform pose = RigidTransform::Identity();
  pose.translation() = Point3(10, 20, depth_mm);
  HandPose hand = HandPose::missing(superset_convention());
  const auto points = landmarks(adult_skeleton(), HandAngles{}, pose);
  for (std::size_t i = 0; i < points.size(); ++i) {
    hand.joints[i] = projection.to_image(points[i]);
    hand.confidence.push_back(0.01f * static_cast<float>(i));
  }
  return hand;
}

TEST(DefinedPose, IsTheSelectionWhereAllOffsetsAreZero) {
  const Projection projection = some_projection();
  HandPose hand = straight_hand(projection);
  hand.joints[9] = {};
  for (const char* name : {"icg20", "mediapipe21", "msra21", "hands21", "knuckle22"}) {
    const Convention& convention = convention_from_name(name);
    const HandPose expected = converted(hand, convention);
    const HandPose defined =
        defined_pose(LandmarkDefinition::plain(convention), hand, projection, HandSide::right);
    EXPECT_EQ(defined.convention, convention);
    EXPECT_EQ(defined.confidence, expected.confidence);
    for (std::size_t i = 0; i < expected.joints.size(); ++i) {
      ASSERT_EQ(defined.joints[i].is_missing(), expected.joints[i].is_missing());
      if (expected.joints[i].is_missing()) continue;
      EXPECT_NEAR(defined.joints[i].u, expected.joints[i].u, 1e-9);
      EXPECT_NEAR(defined.joints[i].v, expected.joints[i].v, 1e-9);
      EXPECT_NEAR(defined.joints[i].depth_mm, expected.joints[i].depth_mm, 1e-9);
    }
  }
}

TEST(DefinedPose, MovesInMillimetresAndMissesWhatIsBehindTheCamera) {
  const Projection projection = some_projection();
  const HandPose hand = straight_hand(projection);
  LandmarkDefinition definition = LandmarkDefinition::plain(convention_from_name("mediapipe21"));
  definition.landmarks[0].offset = {0.0, 0.0, -0.5};  // out of the palm: with z, away from the camera
  const SupersetPoints points = superset_points(hand, projection);
  const HandPose moved = defined_pose(definition, hand, projection, HandSide::right);
  const Point3 wrist = projection.to_camera(moved.joints[0]);
  EXPECT_NEAR((wrist - points[0]).norm(), 0.5 * palm_length(points), 1e-9);
  EXPECT_GT(wrist.z(), points[0].z() + 0.4 * palm_length(points));
  definition.landmarks[0].offset = {0.0, 0.0, 2.0};
  for (const CameraModel model : {CameraModel::projective, CameraModel::orthographic}) {
    const Projection near = some_projection(model);
    const HandPose behind = defined_pose(definition, straight_hand(near, 100.0), near, HandSide::right);
    EXPECT_TRUE(behind.joints[0].is_missing());
    EXPECT_FALSE(behind.joints[1].is_missing());
  }
}

TEST(DefinedPose, NobodyIsSureOfALandmarkThatThePoseLacks) {
  const Projection projection = some_projection();
  const HandPose without_wrist = converted(straight_hand(projection), convention_from_name("icg20"));
  ASSERT_LT(without_wrist.convention.index_of(Landmark::wrist), 0);
  const HandPose defined = defined_pose(LandmarkDefinition::plain(convention_from_name("mediapipe21")),
                                        without_wrist, projection, HandSide::right);
  EXPECT_TRUE(defined.joints[0].is_missing());
  EXPECT_EQ(defined.confidence[0], 0.0f);
  EXPECT_GT(defined.confidence[8], 0.0f);
}

TEST(DefinedPose, NeedsAllLandmarks) {
  EXPECT_NO_THROW(require_all_landmarks(superset_convention(), "poses.txt"));
  const std::string error =
      error_of([] { require_all_landmarks(convention_from_name("icg20"), "poses.txt"); });
  EXPECT_THAT(error, HasSubstr("poses.txt"));
  EXPECT_THAT(error, HasSubstr("'wrist'"));
}

}  // namespace
}  // namespace knuckle
