// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/render/occlusion.h"

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/testing_ray_caster.h"
#include "knuckle/synth/scene/shapes.h"

namespace knuckle {
namespace {

const Camera kCamera{.width = 160, .height = 120, .fx = 112, .fy = 112, .cx = 79.5, .cy = 59.5};

TEST(RenderGroups, EachGroupIsWhatItIsAloneAndTheNearestIsTheWhole) {
  SceneMesh mesh;
  for (std::uint64_t i = 0; i < 5; ++i) {
    Random random(1, i);
    const auto depth = static_cast<float>(random.uniform(200, 500));
    mesh.append(box_shape({80, 90, 100}).mesh,
                standing({static_cast<float>(random.uniform(-90, 90)), 0, depth}, Eigen::Vector3f::UnitY(),
                         random.uniform(0, 3)));
  }
  const std::array<std::size_t, 3> ends = {12, 36, 60};
  const RasteriserOptions options{.culling = FaceCulling::back_faces};
  const auto groups = render_groups(mesh.triangles(), ends, kCamera, options);
  const Rendering whole = render(mesh.triangles(), kCamera, options);
  const Rendering nearest = nearest_of(groups);
  EXPECT_EQ(nearest.depth_mm, whole.depth_mm);
  EXPECT_EQ(nearest.face, whole.face);
  const Rendering first = render({mesh.vertices, std::span(mesh.faces).first(12)}, kCamera, options);
  EXPECT_EQ(groups[0].depth_mm, first.depth_mm);
  for (const std::int32_t face : groups[1].face.pixels()) EXPECT_TRUE(face < 0 || (face >= 12 && face < 36));
  EXPECT_THAT(
      testing::error_of([&] { render_groups(mesh.triangles(), std::array<std::size_t, 1>{61}, kCamera); }),
      ::testing::HasSubstr("61"));
}

/// Against rays through the pixels' centres, over every triangle.
TEST(Occluders, AreWhatRaysMeetFirst) {
  const Body body = testing::box_hand_body();
  const ShapedBody person = shaped_body(body, std::vector<double>(body.shapedirs.size(), 0.0));
  const BodyRig rig(person);
  const Projection projection(kCamera);
  std::array<int, 6> counts{};
  int differing = 0;
  for (std::int64_t i = 0; i < 40; ++i) {
    const PlacedPosture placed = posture_of_frame(rig, kCamera, {}, 3, i);
    const PosedBody posed = posed_body(person, rig.pose(placed.posture, placed.camera_from_body));
    HandPose pose{superset_convention(), {}, {}};
    for (const Point3& landmark : posed.landmarks) pose.joints.push_back(projection.to_image(landmark));
    SceneMesh hand;
    SceneMesh arm;
    for (std::size_t f = 0; f < body.faces.size(); ++f)
      (body.is_hand[f] != 0 ? hand : arm).faces.push_back(body.faces[f]);
    hand.vertices = arm.vertices = posed.vertices;
    SceneMesh things;
    Random random(9, static_cast<std::uint64_t>(i));
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f foot = (0.85 * posed.landmarks[random.below(kSupersetSize)]).cast<float>();
      things.append(box_shape({15, 15, 30}).mesh, standing(foot, Eigen::Vector3f::UnitX(), 0.3));
    }
    const RasteriserOptions options{.culling = FaceCulling::back_faces};
    const Rendering hand_seen = render(hand.triangles(), kCamera, options);
    const Rendering arm_seen = render(arm.triangles(), kCamera, options);
    const Rendering things_seen = render(things.triangles(), kCamera, options);
    const std::array<LabelledRendering, 2> others = {
        {{PixelLabel::person, &arm_seen}, {PixelLabel::object, &things_seen}}};
    const auto occluders = occluders_of(posed.landmarks, pose, hand_seen, others);
    for (int k = 0; k < kSupersetSize; ++k) {
      ++counts[static_cast<std::size_t>(occluders[k])];
      const double u = std::floor(pose.joints[k].u + 0.5);
      const double v = std::floor(pose.joints[k].v + 0.5);
      if (!hand_seen.face.contains(static_cast<int>(u), static_cast<int>(v))) {
        EXPECT_EQ(occluders[k], Occluder::border);
        continue;
      }
      const double own = testing::cast_ray(hand.triangles(), projection, u, v, 20.0).depth_mm;
      const double by_arm = testing::cast_ray(arm.triangles(), projection, u, v, 20.0).depth_mm;
      const double by_thing = testing::cast_ray(things.triangles(), projection, u, v, 20.0).depth_mm;
      const double z = posed.landmarks[k].z();
      const double skin = std::min(own, z);
      const double flesh = flesh_mm(static_cast<Landmark>(k), posed.landmarks);
      Occluder expected = own < z - flesh ? Occluder::own_hand : Occluder::none;
      if (by_arm < skin && by_arm < by_thing) expected = Occluder::person;
      if (by_thing < skin && by_thing <= by_arm) expected = Occluder::object;
      if (expected != occluders[k]) ++differing;  // a ray along an edge may fall to either side
    }
  }
  EXPECT_LE(differing, 3) << "of 880";
  EXPECT_GT(counts[static_cast<std::size_t>(Occluder::none)], 200);
  EXPECT_GT(counts[static_cast<std::size_t>(Occluder::own_hand)], 20);
  EXPECT_GT(counts[static_cast<std::size_t>(Occluder::object)], 50);
}

}  // namespace
}  // namespace knuckle
