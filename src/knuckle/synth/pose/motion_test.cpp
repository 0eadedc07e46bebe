// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/motion.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/hand/hand_collision.h"
#include "knuckle/hand/testing_body.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/pose/gestures.h"

namespace knuckle {
namespace {

/// MakeHuman's mean adult, or the test body where MakeHuman is not here.
class MotionTest : public ::testing::Test {
 protected:
  static Body some_body() {
    const bool is_here = std::filesystem::exists(makehuman_folder() / "public");
    return is_here ? makehuman_body(makehuman_folder()) : testing::box_hand_body();
  }
  static std::vector<double> some_shape(const Body& body) {
    const bool is_here = std::filesystem::exists(makehuman_folder() / "public");
    return is_here ? shape_coefficients(body, PersonShape{})
                   : std::vector<double>(body.shapedirs.size(), 0.0);
  }
  double penetration(const HandAngles& hand) const {
    return worst_penetration_mm(rig_.landmarks(rig_.pose({hand, {}}, Eigen::Isometry3f::Identity())));
  }
  std::vector<double> angles(const PostureOptions& options, std::int64_t index) const {
    const Posture posture = posture_of_frame(rig_, camera_, options, 7, index).posture;
    std::vector<double> values(posture.hand.radians.begin(), posture.hand.radians.end());
    std::ranges::copy(posture.arm.values(), std::back_inserter(values));
    return values;
  }

  Body body_ = some_body();
  ShapedBody person_ = shaped_body(body_, some_shape(body_));
  BodyRig rig_{person_};
  Camera camera_{.width = 320, .height = 240, .fx = 224, .fy = 224, .cx = 159.5, .cy = 119.5};
};

/// Dual quaternions end where the hand does: the skin must not tear there.
TEST_F(MotionTest, TheWristIsSmoothUnderDualQuaternions) {
  PostureOptions options;
  options.placement.wrist_deg = 30.0;
  double worst = 0.0;
  for (int i = 0; i < 60; ++i) {
    const PlacedPosture placed = posture_of_frame(rig_, camera_, options, 2, i);
    const BodyPose pose = rig_.pose(placed.posture, placed.camera_from_body);
    const PosedBody linear = posed_body(person_, pose);
    const PosedBody rigid = posed_body(person_, pose, Skinning::dual_quaternion);
    for (std::size_t f = 0; f < body_.faces.size(); ++f) {
      if (body_.is_hand[f] != 0) continue;
      for (const std::int32_t vertex : body_.faces[f]) {
        worst = std::max<double>(worst, (linear.vertices[vertex] - rigid.vertices[vertex]).norm());
      }
    }
  }
  EXPECT_LT(worst, 1.0);
}

TEST_F(MotionTest, SampledHandsDoNotRunIntoThemselves) {
  const HandPoseOptions options;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    Random random(1, i);
    EXPECT_LE(penetration(sampled_free_hand(rig_, options, random)), options.penetration_mm) << i;
  }
}

TEST_F(MotionTest, NoGestureRunsIntoItself) {
  for (const Gesture& gesture : gestures()) {
    EXPECT_LE(penetration(gesture.angles), HandPoseOptions{}.penetration_mm) << gesture.name;
  }
}

TEST_F(MotionTest, HandsOnTheWayDoNotEither) {
  PostureOptions options;
  options.motion.motion = "smooth";
  double worst = 0.0;
  int deep = 0;
  constexpr int kFrames = 2000;
  for (int i = 0; i < kFrames; ++i) {
    const Posture posture = posture_of_frame(rig_, camera_, options, 3, i).posture;
    const double depth = penetration(posture.hand);
    worst = std::max(worst, depth);
    deep += depth > options.hand.penetration_mm + 1.0 ? 1 : 0;
  }

  EXPECT_LE(deep, kFrames / 200);
  EXPECT_LT(worst, 12.0);
}

TEST_F(MotionTest, AccelerationIsBoundedAndContinuous) {
  PostureOptions options;
  options.motion = {.motion = "smooth", .frames_a_pose = 60};
  constexpr int kPoses = 4;
  std::vector<std::vector<double>> frames;
  for (int i = 0; i <= 60 * kPoses; ++i) frames.push_back(angles(options, i));
  for (std::size_t k = 0; k < frames[0].size(); ++k) {
    double last_acceleration = 0.0;
    for (std::size_t i = 1; i + 1 < frames.size(); ++i) {
      const double acceleration = frames[i + 1][k] - 2.0 * frames[i][k] + frames[i - 1][k];
      // No angle travels more than 2.5 rad, by way of a relaxed hand; a frame is 1/60 of the way.
      EXPECT_LT(std::abs(acceleration), 25.0 * 2.5 / (60.0 * 60.0)) << "frame " << i << ", angle " << k;
      EXPECT_LT(std::abs(acceleration - last_acceleration), 0.006) << "frame " << i << ", angle " << k;
      last_acceleration = acceleration;
    }
  }
}

TEST_F(MotionTest, EveryPoseIsReachedAtRest) {
  PostureOptions options;
  options.motion = {.motion = "smooth", .frames_a_pose = 200};
  const auto before = angles(options, 199);
  const auto at = angles(options, 200);
  const auto behind = angles(options, 201);
  for (std::size_t k = 0; k < at.size(); ++k) {
    EXPECT_NEAR(before[k], at[k], 1e-4);
    EXPECT_NEAR(behind[k], at[k], 1e-4);
  }
}

/// Angles are interpolated one by one: for a hinge that is the shortest turn, and where a joint has two axes
/// it keeps to what the joint can do, unlike a slerp of quaternions, from which it strays little.
TEST_F(MotionTest, InterpolatedAnglesStayNearTheShortestTurn) {
  const HandRig rig(person_);
  double worst_finger = 0.0;
  double worst_thumb = 0.0;
  for (const Gesture& from : gestures()) {
    for (const Gesture& to : gestures()) {
      const auto a = rig.rotations(from.angles);
      const auto b = rig.rotations(to.angles);
      const auto middle = rig.rotations(interpolated(from.angles, to.angles, 0.5));
      for (std::size_t k = 0; k < a.size(); ++k) {
        const Eigen::Quaternionf shortest = a[k].rotation.slerp(0.5f, b[k].rotation);
        const bool is_thumb = body_.names[static_cast<std::size_t>(a[k].bone)] == "finger1-1.R";
        double& worst = is_thumb ? worst_thumb : worst_finger;
        worst = std::max<double>(worst, shortest.angularDistance(middle[k].rotation));
      }
    }
  }
  EXPECT_LT(worst_finger, 0.12);
  EXPECT_LT(worst_thumb, 0.26);
}

}  // namespace
}  // namespace knuckle
