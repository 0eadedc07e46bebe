// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/hand_track_fit.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle {
namespace {

/// Index and little finger stretched, the others bent, the thumb beside the palm: few hands are held so.
SkeletonPose rare_hand() {
  SkeletonPose pose;
  for (const int finger : {1, 2}) {
    const FingerAngleNames names = angles_of_finger(finger);
    pose.angles[names.mcp] = pose.angles[names.pip] = 1.3;
    pose.angles[names.dip] = coupled_dip(1.3);
  }
  pose.angles[HandAngle::thumb_radial] = 0.4;  // not within the palm
  pose.angles[HandAngle::thumb_palmar] = 0.5;
  pose.camera_from_hand.translation() = Point3(0.0, 0.0, 500.0);
  return pose;
}

LandmarkTargets targets_at(const SkeletonPose& pose) {
  LandmarkTargets targets;
  const auto points = landmarks(adult_skeleton(), pose);
  for (std::size_t i = 0; i < points.size(); ++i) targets[i].point = points[i];
  return targets;
}

double farthest_mm(const SkeletonPose& a, const SkeletonPose& b) {
  const auto of_a = landmarks(adult_skeleton(), a);
  const auto of_b = landmarks(adult_skeleton(), b);
  double farthest = 0.0;
  for (std::size_t i = 0; i < of_a.size(); ++i) farthest = std::max(farthest, (of_a[i] - of_b[i]).norm());
  return farthest;
}

TEST(FitTrack, AHandThatStaysAsItIsIsNotDrawnToWhatHandsAreLike) {
  const RightHandSight sight{.targets = targets_at(rare_hand()), .surface = {}};
  const auto alone = fit_skeleton(adult_skeleton(), sight.targets);
  ASSERT_TRUE(alone);
  HandTrack track(1, 0.0, {});
  PersonHand person;
  for (int i = 0; i < 30; ++i) {
    const double now_s = i / 30.0;
    const auto fit = fit_track(track, sight, now_s, 0.0, person);
    ASSERT_TRUE(fit);
    track.move_to(fit->pose, now_s);
  }
  EXPECT_GT(farthest_mm(alone->pose, rare_hand()), 2.0) << "a single frame knows no better";
  EXPECT_LT(farthest_mm(*track.pose, rare_hand()), 0.5 * farthest_mm(alone->pose, rare_hand()));
}

}  // namespace
}  // namespace knuckle
