// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/second_hand.h"

#include <limits>

#include "knuckle/hand/hand_collision.h"
#include "knuckle/synth/scene/sampling.h"

namespace knuckle {
namespace {

using Landmarks = std::array<Point3, kSupersetSize>;

constexpr double kPressMm = 2.0;  ///< how deep skin may be pressed where hands touch
constexpr double kFarthestShiftMm = 350.0;

const Point3& palm_of(const Landmarks& landmarks) {
  return landmarks[static_cast<std::size_t>(Landmark::palm)];
}

Landmarks reflected(Landmarks landmarks) {
  for (Point3& landmark : landmarks) landmark.x() = -landmark.x();
  return landmarks;
}

Landmarks moved(const RigidTransform& transform, Landmarks landmarks) {
  for (Point3& landmark : landmarks) landmark = transform * landmark;
  return landmarks;
}

/// From the first hand's palm to where the other one's should be [mm].
Point3 sampled_offset(HandMeeting meeting, const Point3& palm, Random& random) {
  const Point3 sight = palm.normalized();
  const Point3 any = normal_vector(random).cast<double>();
  const Point3 beside = (any - sight * sight.dot(any)).normalized();
  const double aslant = random.uniform(-0.6, 0.6);
  if (meeting == HandMeeting::crossed) {
    const double behind = random.uniform(60.0, 220.0) * (random.uniform() < 0.5 ? -1.0 : 1.0);
    return beside * random.uniform(0.0, 80.0) + sight * behind;
  }
  const double distance = meeting == HandMeeting::near ? random.uniform(130.0, 380.0) : 260.0;
  return distance * (beside + aslant * sight).normalized();
}

/// Moves the other hand towards the first until they touch.
RigidTransform until_they_touch(const Landmarks& first, const Landmarks& other, const RigidTransform& start) {
  constexpr int kSteps = 10;
  const auto capsules = hand_capsules(first);
  const Point3 way = palm_of(first) - palm_of(moved(start, other));
  double apart = 0.0;
  double meeting = 1.0;
  RigidTransform place = start;
  for (int step = 0; step < kSteps; ++step) {
    const double middle = 0.5 * (apart + meeting);
    place.translation() = start.translation() + middle * way;
    const double gap = gap_of_hands_mm(capsules, hand_capsules(moved(place, other)));
    (gap > -kPressMm ? apart : meeting) = middle;
  }
  place.translation() = start.translation() + apart * way;
  return place;
}

/// Of some random arms the one whose hand needs the least shift; its palm is then at `wanted`.
struct ReachingArm {
  ArmAngles arm;
  Landmarks landmarks;  ///< of the reflected body
  double shift_mm = std::numeric_limits<double>::infinity();
};

ReachingArm reaching_arm(const BodyRig& rig, const HandAngles& hand, const RigidTransform& camera_from_body,
                         const Point3& wanted, const PlacementOptions& options, Random& random) {
  constexpr int kArms = 24;
  ReachingArm best;
  for (int i = 0; i < kArms; ++i) {
    const ArmAngles arm = sampled_arm(options, random);
    const Landmarks landmarks =
        reflected(rig.landmarks(rig.pose({hand, arm}, Eigen::Isometry3f::Identity())));
    const double shift = (wanted - camera_from_body * palm_of(landmarks)).norm();
    if (shift < best.shift_mm) best = {arm, landmarks, shift};
  }
  return best;
}

}  // namespace

std::optional<SecondHand> sampled_second_hand(const BodyRig& rig, const PlacedPosture& first,
                                              const std::array<Point3, kSupersetSize>& first_landmarks,
                                              const PostureOptions& options, HandMeeting meeting,
                                              Random& random) {
  constexpr int kAttempts = 4;
  const RigidTransform camera_from_body(first.camera_from_body.cast<double>());
  const auto capsules = hand_capsules(first_landmarks);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const HandAngles hand = sampled_free_hand(rig, options.hand, random);
    const Point3 wanted =
        palm_of(first_landmarks) + sampled_offset(meeting, palm_of(first_landmarks), random);
    const ReachingArm reach = reaching_arm(rig, hand, camera_from_body, wanted, options.placement, random);
    if (reach.shift_mm > kFarthestShiftMm) continue;
    RigidTransform place = camera_from_body;
    place.translation() += wanted - camera_from_body * palm_of(reach.landmarks);
    if (meeting == HandMeeting::touching) place = until_they_touch(first_landmarks, reach.landmarks, place);
    const Landmarks landmarks = moved(place, reach.landmarks);
    if (gap_of_hands_mm(capsules, hand_capsules(landmarks)) < -kPressMm) continue;
    return SecondHand{{hand, reach.arm}, landmarks, place};
  }
  return std::nullopt;
}

std::vector<Eigen::Vector3f> skin_of(const SecondHand& hand, const BodyRig& rig, std::size_t vertex_count,
                                     Skinning skinning) {
  const BodyPose pose = rig.pose(hand.posture, Eigen::Isometry3f::Identity());
  std::vector<Eigen::Vector3f> skin = posed_body(rig.person(), pose, vertex_count, skinning).vertices;
  const Eigen::Matrix3f turn = hand.camera_from_mirrored_body.linear().cast<float>();
  const Eigen::Vector3f shift = hand.camera_from_mirrored_body.translation().cast<float>();
  for (Eigen::Vector3f& vertex : skin) {
    vertex.x() = -vertex.x();
    vertex = turn * vertex + shift;
  }
  return skin;
}

}  // namespace knuckle
