// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/placement.h"

#include <numbers>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/pose/gestures.h"

namespace knuckle {
namespace {

Camera test_camera() {
  return {.width = 160, .height = 120, .fx = 112, .fy = 112, .cx = 79.5, .cy = 59.5};
}

/// A rig with the body that it poses.
struct RiggedBody {
  explicit RiggedBody(Body its_body, std::vector<double> coefficients)
      : body(std::move(its_body)), person(shaped_body(body, coefficients)), rig(person) {}
  Body body;
  ShapedBody person;
  BodyRig rig;
};

std::unique_ptr<RiggedBody> box_hand() {
  Body body = testing::box_hand_body();
  std::vector<double> none(body.shapedirs.size(), 0.0);
  return std::make_unique<RiggedBody>(std::move(body), none);
}

TEST(Placement, TheHandIsInTheImageAtTheDistanceAskedFor) {
  const auto hand = box_hand();
  const PlacementOptions options{.nearest_mm = 300, .farthest_mm = 400, .border_share = 0};
  const Projection projection(test_camera());
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(1, i);
    const PlacedPosture placed = sampled_placement(hand->rig, HandAngles{}, test_camera(), options, random);
    const BodyPose pose = hand->rig.pose(placed.posture, placed.camera_from_body);
    ASSERT_EQ(violation(hand->rig, pose, test_camera(), options, 0.0), 0.0) << i;
    const auto landmarks = hand->rig.landmarks(pose);
    const double palm = landmarks[static_cast<std::size_t>(Landmark::palm)].z();
    EXPECT_GE(palm, 299.9);
    EXPECT_LE(palm, 400.1);
    for (const Point3& landmark : landmarks) {
      const ImagePoint point = projection.to_image(landmark);
      EXPECT_TRUE(point.u >= 0 && point.u <= 159 && point.v >= 0 && point.v <= 119);
    }
  }
}

TEST(Placement, NoPartOfTheHandIsSoNearThatItFillsTheImage) {
  const auto hand = box_hand();
  Camera wide = test_camera();
  wide.fx = wide.fy = 30;  // all of a near hand is in the image
  const PlacementOptions options{.nearest_mm = 150, .farthest_mm = 200, .border_share = 0};
  int found = 0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    Random random(7, i);
    const PlacedPosture placed = sampled_placement(hand->rig, HandAngles{}, wide, options, random);
    const BodyPose pose = hand->rig.pose(placed.posture, placed.camera_from_body);
    if (violation(hand->rig, pose, wide, options, 0.0) > 0.0) continue;  // the search may end without one
    ++found;
    for (const Point3& landmark : hand->rig.landmarks(pose)) EXPECT_GE(landmark.z(), 119.9) << i;
  }
  EXPECT_GT(found, 150);
}

TEST(Placement, APresentedHandIsHeldUpWithItsPalmToTheCamera) {
  const auto hand = box_hand();
  const PlacementOptions options{.presented_share = 1.0, .palm_deg = 40, .upright_deg = 60};
  int presented = 0;
  for (std::uint64_t i = 0; i < 50; ++i) {
    Random random(4, i);
    const PlacedPosture placed = sampled_placement(hand->rig, HandAngles{}, test_camera(), options, random);
    const auto landmarks = hand->rig.landmarks(hand->rig.pose(placed.posture, placed.camera_from_body));
    if (presentation_violation(landmarks, options) > 0.0) continue;  // the search may end without one
    ++presented;
    const Point3 palm = landmarks[static_cast<std::size_t>(Landmark::palm)];
    const Point3 along_hand = landmarks[static_cast<std::size_t>(Landmark::middle_mcp)] -
                              landmarks[static_cast<std::size_t>(Landmark::wrist)];
    EXPECT_GE(hand_axes(landmarks).col(2).dot(-palm.normalized()), std::cos(60.0 * std::numbers::pi / 180));
    EXPECT_LT(along_hand.y(), 0.0) << "up in the image";
  }
  EXPECT_GT(presented, 25) << "of 50; without the option it is about one in twenty";
}

TEST(Placement, ComesFromTheStreamAlone) {
  const auto hand = box_hand();
  const auto place = [&](std::uint64_t stream) {
    Random random(2, stream);
    return sampled_placement(hand->rig, HandAngles{}, test_camera(), {}, random);
  };
  EXPECT_EQ(place(5).camera_from_body.matrix(), place(5).camera_from_body.matrix());
  EXPECT_NE(place(5).camera_from_body.matrix(), place(6).camera_from_body.matrix());
}

TEST(Placement, PalmBackAndSideViewsAllOccur) {
  const auto hand = box_hand();
  std::array<int, 3> seen{};  // palm, side, back
  for (std::uint64_t i = 0; i < 300; ++i) {
    Random random(3, i);
    const PlacedPosture placed = sampled_placement(hand->rig, HandAngles{}, test_camera(), {}, random);
    const auto landmarks = hand->rig.landmarks(hand->rig.pose(placed.posture, placed.camera_from_body));
    const double palm_towards_camera = -hand_axes(landmarks).col(2).z();
    ++seen[palm_towards_camera > 0.5 ? 0 : palm_towards_camera > -0.5 ? 1 : 2];
  }
  for (const int count : seen) EXPECT_GT(count, 30);
}

TEST(Placement, NothingOfAPersonIsBeforeTheHand) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) {
    GTEST_SKIP() << "MakeHuman's data is not on this machine (scripts/fetch_makehuman.sh)";
  }
  Body body = makehuman_body(makehuman_folder());
  const std::vector<double> shape = shape_coefficients(body, PersonShape{});
  const RiggedBody human(std::move(body), shape);
  const PlacementOptions options{.border_share = 0};
  for (std::uint64_t i = 0; i < 50; ++i) {
    Random random(4, i);
    const HandAngles& hand = gesture_from_name("open").angles;
    const PlacedPosture placed = sampled_placement(human.rig, hand, test_camera(), options, random);
    const PosedBody posed = posed_body(human.person, human.rig.pose(placed.posture, placed.camera_from_body));
    float hand_depth = std::numeric_limits<float>::infinity();
    for (const Point3& point : posed.landmarks)
      hand_depth = std::min(hand_depth, static_cast<float>(point.z()));
    const Projection projection(test_camera());
    for (const Eigen::Vector3f& vertex : posed.vertices) {
      if (vertex.z() < 20.0f) continue;
      const ImagePoint point = projection.to_image(vertex.cast<double>());
      if (point.u < 0 || point.u > 159 || point.v < 0 || point.v > 119) continue;
      EXPECT_GT(vertex.z(), hand_depth - options.forearm_margin_mm - 40.0) << "frame " << i;
    }
  }
}

TEST(Placement, RefusesImpossibleOptions) {
  const auto message = [](const PlacementOptions& options) {
    return testing::error_of([&] { check(options, "here"); });
  };
  EXPECT_THAT(message({.nearest_mm = 900, .farthest_mm = 400}), ::testing::HasSubstr("nearest_mm is 900"));
  EXPECT_THAT(message({.facing_share = 0, .shoulder_share = 0, .free_share = 0}),
              ::testing::HasSubstr("facing_share"));
  EXPECT_THAT(message({.off_centre = -1}), ::testing::HasSubstr("off_centre"));
}

}  // namespace
}  // namespace knuckle
