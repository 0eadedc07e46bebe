// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/view_culling.h"

#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/rasteriser.h"

namespace knuckle {
namespace {

/// Renders postures whole and culled; returns in how many the trunk could be left out.
int trunkless_frames(const Body& body, const std::vector<double>& coefficients, const Camera& camera,
                     int frames) {
  const ShapedBody person = shaped_body(body, coefficients);
  const BodyRig rig(person);
  const ViewCulling culling(person);
  PostureOptions postures;
  postures.placement.nearest_mm = 200;
  postures.placement.farthest_mm = 700;
  int culled = 0;
  for (int i = 0; i < frames; ++i) {
    const PlacedPosture placed = posture_of_frame(rig, camera, postures, 5, i);
    const BodyPose pose = rig.pose(placed.posture, placed.camera_from_body);
    const BodySection section = culling.visible_section(bone_transforms(person, pose), camera);
    if (section.faces == static_cast<std::int32_t>(body.faces.size())) continue;
    ++culled;
    const PosedBody whole = posed_body(person, pose, Skinning::dual_quaternion);
    const PosedBody part =
        posed_body(person, pose, static_cast<std::size_t>(section.vertices), Skinning::dual_quaternion);
    const Rendering expected = render({whole.vertices, body.faces}, camera);
    const Rendering rendering =
        render({part.vertices, std::span(body.faces).first(static_cast<std::size_t>(section.faces))}, camera);
    EXPECT_EQ(rendering.depth_mm, expected.depth_mm) << i;
    EXPECT_EQ(rendering.face, expected.face) << i;
  }
  return culled;
}

TEST(ViewCulling, LeavesOutOnlyWhatIsNotSeen) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) GTEST_SKIP() << "MakeHuman's data is not here";
  const Body body = makehuman_body(makehuman_folder());
  const std::vector<double> shape = shape_coefficients(body, PersonShape{});
  Camera camera{.width = 80, .height = 60, .fx = 140, .fy = 140, .cx = 39.5, .cy = 29.5};  // a narrow view
  EXPECT_GT(trunkless_frames(body, shape, camera, 150), 5);
  camera.fx = camera.fy = 0.25;
  camera.model = CameraModel::orthographic;
  EXPECT_GT(trunkless_frames(body, shape, camera, 150), 0);
}

TEST(ViewCulling, ADistortedCameraSeesTheWholeBody) {
  Body body = testing::box_hand_body();
  body.sections.insert(body.sections.begin(), BodySection{16, 20});
  const ShapedBody person = shaped_body(body, std::vector<double>(body.shapedirs.size(), 0.0));
  BodyPose pose;
  pose.rotations.assign(body.names.size(), Eigen::Quaternionf::Identity());
  pose.camera_from_body.translation().z() = -5000.0f;  // behind the camera
  Camera camera{.width = 80, .height = 60, .fx = 56, .fy = 56, .cx = 39.5, .cy = 29.5};
  const auto transforms = bone_transforms(person, pose);
  const ViewCulling culling(person);
  EXPECT_EQ(culling.visible_section(transforms, camera), body.sections.front());
  camera.distortion[0] = 0.1;
  EXPECT_EQ(culling.visible_section(transforms, camera).faces, static_cast<std::int32_t>(body.faces.size()));
}

}  // namespace
}  // namespace knuckle
