// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/second_hand.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include "knuckle/core/portable_math.h"
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

/// Across the line of sight; of hands that touch, away from the first one.
HandPath sampled_path(HandMeeting meeting, const Point3& first, const Point3& other, Random& random) {
  const double length = random.uniform(150.0, 250.0);
  if (meeting == HandMeeting::touching) {
    const Eigen::Vector3d away = (other - first).normalized() * length;
    return {0.5 * away, 0.5 * away};
  }
  const Point3 sight = first.normalized();
  const Point3 any = normal_vector(random).cast<double>();
  return {Eigen::Vector3d::Zero(), length * (any - sight * sight.dot(any)).normalized()};
}

/// Whether a hand runs into the first one, at any moment of that and anywhere on its path.
bool collides(const SecondHand& second, const FirstHand& first) {
  constexpr int kPhases = 9;               // of one way
  constexpr double kDeepestTouchMm = 8.0;  // flesh yields, and the first hand moves a little
  for (int i = 0; i < kPhases; ++i) {
    const auto capsules = hand_capsules(second.at(0.5 * i / (kPhases - 1)).landmarks);
    const auto meets = [&](const Landmarks& landmarks) {
      return gap_of_hands_mm(hand_capsules(landmarks), capsules) < -kDeepestTouchMm;
    };
    if (std::ranges::any_of(first.moments, meets)) return true;
  }
  return false;
}

}  // namespace

Eigen::Vector3d HandPath::shift(double phase) const {
  return middle + portable_cos(2.0 * std::numbers::pi * phase) * reach;
}

SecondHand SecondHand::at(double phase) const {
  SecondHand hand = *this;
  const Eigen::Vector3d shift = path.shift(phase);
  for (Point3& landmark : hand.landmarks) landmark += shift;
  hand.camera_from_mirrored_body.translation() += shift;
  return hand;
}

std::optional<SecondHand> sampled_second_hand(const BodyRig& rig, const FirstHand& first,
                                              const PostureOptions& options, HandMeeting meeting, bool passes,
                                              Random& random) {
  constexpr int kAttempts = 4;
  const RigidTransform camera_from_body(first.posture.camera_from_body.cast<double>());
  const Landmarks& first_landmarks = first.landmarks;
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
    SecondHand second{{hand, reach.arm}, landmarks, place, {}};
    if (!passes) return second;
    second.path = sampled_path(meeting, palm_of(first_landmarks), palm_of(landmarks), random);
    if (!collides(second, first)) return second;
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
