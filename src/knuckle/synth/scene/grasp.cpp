// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/grasp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/core/angle.h"
#include "knuckle/core/error.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/hand/hand_collision.h"
#include "knuckle/hand/rotation_between.h"
#include "knuckle/synth/pose/gestures.h"
#include "knuckle/synth/scene/sampling.h"

namespace knuckle {
namespace {

using Landmarks = std::array<Point3, kSupersetSize>;

constexpr double kDeepestMm = 4.0;  ///< flesh yields so far
constexpr double kTouchMm = 2.5;    ///< nearer than this is a touch
constexpr double kSlightMm = 0.5;   ///< closing fingers stop once they press in so far

/// A capsule's points, close enough for things larger than a finger.
constexpr int kPointsPerCapsule = 4;

const Point3& at(const Landmarks& landmarks, Landmark landmark) {
  return landmarks[static_cast<std::size_t>(landmark)];
}

/// Distance from the wrist to the middle MCP: the hand's unit of length [mm].
double unit_of(const Landmarks& landmarks) {
  return (at(landmarks, Landmark::middle_mcp) - at(landmarks, Landmark::wrist)).norm();
}

Landmarks posed(const HandSkeleton& skeleton, const HandAngles& angles) {
  return landmarks(skeleton, angles, RigidTransform::Identity());
}

double gap_of_capsule(const HandCapsule& capsule, const Grasp& grasp, const RigidTransform& thing_from_hand) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kPointsPerCapsule; ++i) {
    const Point3 point = capsule.from + (capsule.to - capsule.from) * (double{1} / kPointsPerCapsule * i);
    const Eigen::Vector3f place = (thing_from_hand * point).cast<float>();
    least = std::min(least, static_cast<double>(distance_mm(grasp.thing.solids, place)) - capsule.radius);
  }
  return least;
}

/// The gap of one digit, or of the palm.
double gap_of_digit(const Landmarks& landmarks, const Grasp& grasp, int digit) {
  const RigidTransform thing_from_hand = grasp.hand_from_thing.inverse();
  double least = std::numeric_limits<double>::infinity();
  for (const HandCapsule& capsule : hand_capsules(landmarks)) {
    if (capsule.digit == digit) least = std::min(least, gap_of_capsule(capsule, grasp, thing_from_hand));
  }
  return least;
}

/// The joints that close a digit, from the palm outwards, and where each of them ends.
struct ClosingJoint {
  HandAngle angle;
  double end_deg;
};

std::vector<ClosingJoint> closing_joints(int digit) {
  if (digit == 0) {
    return {{HandAngle::thumb_radial, 2.0}, {HandAngle::thumb_mcp, 50.0}, {HandAngle::thumb_ip, 65.0}};
  }
  const FingerAngleNames names = angles_of_finger(digit - 1);
  return {{names.mcp, 88.0}, {names.pip, 105.0}, {names.dip, 60.0}};
}

/// Bends a digit, all its joints at once, each until it would press into the thing.
void close_digit(const HandSkeleton& skeleton, Grasp& grasp, int digit) {
  constexpr int kSteps = 24;
  const std::vector<ClosingJoint> joints = closing_joints(digit);
  std::array<double, 3> step{};
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const AngleRange range = range_of(joints[k].angle);
    const double end = std::clamp(joints[k].end_deg * kDegree, range.low, range.high);
    step[k] = (end - grasp.hand[joints[k].angle]) / kSteps;
  }
  std::array<bool, 3> is_stopped{};
  for (int i = 0; i < kSteps; ++i) {
    for (std::size_t k = 0; k < joints.size(); ++k) {
      if (is_stopped[k]) continue;
      grasp.hand[joints[k].angle] += step[k];
      if (gap_of_digit(posed(skeleton, grasp.hand), grasp, digit) >= -kSlightMm) continue;
      grasp.hand[joints[k].angle] -= step[k];
      is_stopped[k] = true;
    }
  }
}

void close_hand(const HandSkeleton& skeleton, Grasp& grasp) {
  for (const int digit : {1, 2, 3, 4, 0}) close_digit(skeleton, grasp, digit);
}

HandAngles open_hand(Random& random) {
  HandAngles hand;
  hand[HandAngle::thumb_radial] = random.uniform(38.0, 55.0) * kDegree;
  hand[HandAngle::thumb_palmar] = random.uniform(42.0, 62.0) * kDegree;
  hand[HandAngle::thumb_twist] = random.uniform(0.0, 15.0) * kDegree;
  hand[HandAngle::palm_arch] = random.uniform(0.0, 12.0) * kDegree;
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    hand[names.mcp] = random.uniform(-5.0, 12.0) * kDegree;
    hand[names.pip] = random.uniform(3.0, 12.0) * kDegree;
    hand[names.spread] = random.uniform(-1.0, 5.0) * kDegree;
  }
  return hand;
}

HandAngles jittered(std::string_view gesture, double jitter_deg, Random& random) {
  HandAngles hand = gesture_from_name(gesture).angles;
  for (double& angle : hand.radians) angle += jitter_deg * kDegree * random.normal();
  return clamped(hand);
}

/// The turn that takes the z axis to `axis`, after a turn about itself.
Eigen::Matrix3d axes_along(const Point3& axis, double turn) {
  return (rotation_between(Point3::UnitZ(), axis) * rotation_about(turn, Point3::UnitZ()))
      .normalized()
      .toRotationMatrix();
}

/// Puts the middle of a thing of height `height` at `centre`.
RigidTransform centred(const Eigen::Matrix3d& axes, const Point3& centre, double height) {
  RigidTransform place = RigidTransform::Identity();
  place.linear() = axes;
  place.translation() = centre - axes.col(2) * (0.5 * height);
  return place;
}

/// How far flesh lies before the palm's bones, and where fingers begin.
struct PalmPlace {
  double skin;
  double roots;
};

PalmPlace palm_place(const HandSkeleton& skeleton) {
  const Landmarks straight = posed(skeleton, HandAngles{});
  return {0.125 * unit_of(straight), at(straight, Landmark::middle_mcp).y()};
}

Grasp cylinder_grasp(const HandSkeleton& skeleton, Random& random) {
  Grasp grasp{.hand = open_hand(random), .thing = {}};
  const PalmPlace palm = palm_place(skeleton);
  const double radius = random.uniform(9.0, 42.0);
  const double top = radius * (random.uniform() < 0.5 ? 1.0 : random.uniform(0.75, 1.2));
  const double height = random.uniform(90.0, 230.0);
  grasp.thing = cone_shape(static_cast<float>(radius), static_cast<float>(top), static_cast<float>(height));
  const double slant = random.uniform(-10.0, 40.0) * kDegree;
  const Point3 axis(portable_cos(slant), -portable_sin(slant), 0.0);
  const double widest = std::max(radius, top);
  const Point3 centre(random.uniform(-0.25, 0.25) * height, palm.roots - random.uniform(0.0, 0.7) * widest,
                      palm.skin + widest);
  grasp.hand_from_thing = centred(axes_along(axis, 0.0), centre, height);
  return grasp;
}

Grasp box_grasp(const HandSkeleton& skeleton, Random& random) {
  Grasp grasp{.hand = open_hand(random), .thing = {}};
  const PalmPlace palm = palm_place(skeleton);
  const double thick = random.uniform(12.0, 55.0);
  const double wide = random.uniform(20.0, 75.0);
  const double height = random.uniform(70.0, 200.0);
  // About its own z the box is turned so that its thickness points out of the palm.
  grasp.thing = box_shape({static_cast<float>(thick), static_cast<float>(wide), static_cast<float>(height)});
  Eigen::Matrix3d axes;
  axes << Point3::UnitZ(), Point3::UnitY(), -Point3::UnitX();
  const double slant = random.uniform(-12.0, 30.0) * kDegree;
  axes = rotation_about(-slant, Point3::UnitZ()).toRotationMatrix() * axes;
  const Point3 centre(random.uniform(-0.25, 0.25) * height, palm.roots + random.uniform(-0.25, 0.3) * wide,
                      palm.skin + 0.5 * thick);
  grasp.hand_from_thing = centred(axes, centre, height);
  return grasp;
}

Grasp ball_grasp(const HandSkeleton& skeleton, Random& random) {
  Grasp grasp{.hand = open_hand(random), .thing = {}};
  const PalmPlace palm = palm_place(skeleton);
  const double radius = random.uniform(20.0, 42.0);
  for (int finger = 0; finger < 4; ++finger)
    grasp.hand[angles_of_finger(finger).spread] = random.uniform(2.0, 14.0) * kDegree;
  grasp.thing = ball_shape(static_cast<float>(radius));
  const Point3 centre(random.uniform(-6.0, 10.0), palm.roots + random.uniform(-0.2, 0.35) * radius,
                      palm.skin + radius);
  grasp.hand_from_thing = centred(Eigen::Matrix3d::Identity(), centre, 2.0 * radius);
  return grasp;
}

/// A thing that fits between two places of skin: `gap` apart along z.
Shape thing_between(double gap, Random& random) {
  const auto thickness = static_cast<float>(gap);
  const double kind = random.uniform();
  if (kind < 0.4) return box_shape({between(random, 8, 55), between(random, 8, 55), thickness});
  if (kind < 0.6) return cone_shape(between(random, 6, 30), between(random, 6, 30), thickness);
  if (kind < 0.75) return ball_shape(0.5f * thickness);
  Shape shape;  // a pen or roll, across
  const float length = between(random, 40, 170);
  RigidTransform place = RigidTransform::Identity();
  place.linear() = axes_along(Point3::UnitX(), 0.0);
  place.translation() = Point3(-random.uniform(0.2, 0.8) * length, 0.0, 0.5 * gap);
  shape.append(cone_shape(0.5f * thickness, 0.5f * thickness, length, 14),
               Eigen::Isometry3f(place.cast<float>()));
  return shape;
}

Grasp tips_grasp(const HandSkeleton& skeleton, std::span<const std::string_view> gestures,
                 std::span<const Landmark> tips, Random& random) {
  const std::string_view gesture = gestures[random.below(static_cast<std::uint32_t>(gestures.size()))];
  Grasp grasp{.hand = jittered(gesture, 4.0, random), .thing = {}};
  const Landmarks hand = posed(skeleton, grasp.hand);
  Point3 fingers = Point3::Zero();
  for (const Landmark tip : tips) fingers += at(hand, tip) / static_cast<double>(tips.size());
  const Point3& thumb = at(hand, Landmark::thumb_tip);
  const double unit = unit_of(hand);
  constexpr double kThumbFlesh = 0.085;
  constexpr double kFingerFlesh = 0.068;
  const double distance = (fingers - thumb).norm();
  const double gap = distance - (kThumbFlesh + kFingerFlesh) * unit;
  if (gap < 2.0) return grasp;  // nothing fits
  const Point3 direction = (fingers - thumb) / distance;
  const Point3 middle = thumb + direction * (kThumbFlesh * unit + 0.5 * gap);
  grasp.thing = thing_between(gap, random);
  grasp.hand_from_thing = centred(axes_along(direction, random.uniform(0.0, 6.28)), middle, gap);
  return grasp;
}

Grasp pinch_grasp(const HandSkeleton& skeleton, Random& random) {
  constexpr std::array<std::string_view, 4> kGestures = {"pinch_open", "pinch", "ok", "disk"};
  constexpr std::array<Landmark, 1> kTips = {Landmark::index_tip};
  return tips_grasp(skeleton, kGestures, kTips, random);
}

Grasp tripod_grasp(const HandSkeleton& skeleton, Random& random) {
  constexpr std::array<std::string_view, 4> kGestures = {"tripod", "disk", "sphere", "cylinder"};
  constexpr std::array<Landmark, 2> kTips = {Landmark::index_tip, Landmark::middle_tip};
  return tips_grasp(skeleton, kGestures, kTips, random);
}

/// A card, key or phone between the thumb and the side of the index finger.
Grasp lateral_grasp(const HandSkeleton& skeleton, Random& random) {
  Grasp grasp{.hand = jittered("lateral_pinch", 4.0, random), .thing = {}};
  grasp.hand[HandAngle::thumb_radial] += random.uniform(2.0, 14.0) * kDegree;
  const Landmarks hand = posed(skeleton, grasp.hand);
  const Point3 side = 0.5 * (at(hand, Landmark::index_pip) + at(hand, Landmark::index_dip));
  const Point3& thumb = at(hand, Landmark::thumb_tip);
  const double unit = unit_of(hand);
  constexpr double kThumbFlesh = 0.085;
  constexpr double kFingerFlesh = 0.078;
  const double distance = (side - thumb).norm();
  const double gap = distance - (kThumbFlesh + kFingerFlesh) * unit;
  if (gap < 0.8) return grasp;
  const Point3 direction = (side - thumb) / distance;
  const Point3 middle = thumb + direction * (kThumbFlesh * unit + 0.5 * gap);
  const float length = between(random, 40, 140);
  Shape card = box_shape({between(random, 15, 70), length, static_cast<float>(gap)});
  RigidTransform ahead = RigidTransform::Identity();
  ahead.translation().y() = random.uniform(0.1, 0.45) * length;
  grasp.thing.append(card, Eigen::Isometry3f(ahead.cast<float>()));
  // The card's y axis points forward, out of the hand.
  const Point3 forward = (Point3::UnitY() - direction * direction.y()).normalized();
  Eigen::Matrix3d axes;
  axes << forward.cross(direction), forward, direction;
  grasp.hand_from_thing = centred(axes, middle, gap);
  return grasp;
}

/// A handle in bent fingers.
Grasp hook_grasp(const HandSkeleton& skeleton, Random& random) {
  Grasp grasp{.hand = open_hand(random), .thing = {}};
  const PalmPlace palm = palm_place(skeleton);
  const double radius = random.uniform(5.0, 14.0);
  const double length = random.uniform(90.0, 200.0);
  grasp.thing =
      cone_shape(static_cast<float>(radius), static_cast<float>(radius), static_cast<float>(length));
  grasp.hand[HandAngle::thumb_palmar] = random.uniform(5.0, 30.0) * kDegree;
  const Point3 centre(random.uniform(-8.0, 8.0), palm.roots + random.uniform(14.0, 26.0),
                      palm.skin * 0.8 + radius);
  grasp.hand_from_thing = centred(axes_along(Point3::UnitX(), 0.0), centre, length);
  return grasp;
}

/// Something flat that lies on the open hand.
Grasp palm_grasp(const HandSkeleton& skeleton, Random& random) {
  Grasp grasp{.hand = jittered(random.uniform() < 0.5 ? "flat" : "relaxed", 3.0, random), .thing = {}};
  const Landmarks hand = posed(skeleton, grasp.hand);
  const Eigen::Vector3f extents(between(random, 45, 170), between(random, 70, 220), between(random, 6, 70));
  grasp.thing = random.uniform() < 0.7 ? box_shape(extents)
                                       : cone_shape(0.4f * extents.x(), 0.4f * extents.x(), extents.z());
  RigidTransform place = RigidTransform::Identity();
  place.linear() = rotation_about(random.uniform(-0.5, 0.5), Point3::UnitZ()).toRotationMatrix();
  place.translation() =
      Point3(random.uniform(-10.0, 15.0), at(hand, Landmark::palm).y() + random.uniform(-10.0, 50.0), 0.0);
  grasp.hand_from_thing = place;
  // It comes down from above until it lies on the highest flesh below it.
  double low = 0.0;
  double high = 150.0;
  for (int step = 0; step < 12; ++step) {
    grasp.hand_from_thing.translation().z() = 0.5 * (low + high);
    const bool is_free = gap_to_thing_mm(hand, grasp) > -1.0;
    (is_free ? high : low) = 0.5 * (low + high);
  }
  grasp.hand_from_thing.translation().z() = high;
  grasp.lies_on_hand = true;
  return grasp;
}

struct GraspKind {
  std::string_view name;
  Grasp (*make)(const HandSkeleton&, Random&);
  bool closes;  ///< the fingers then close on the thing
};

constexpr std::array<GraspKind, 8> kGrasps = {{{"cylinder", cylinder_grasp, true},
                                               {"box", box_grasp, true},
                                               {"ball", ball_grasp, true},
                                               {"pinch", pinch_grasp, false},
                                               {"tripod", tripod_grasp, false},
                                               {"lateral", lateral_grasp, false},
                                               {"hook", hook_grasp, true},
                                               {"palm", palm_grasp, false}}};

/// Two parts of the hand touch the thing, and none presses in too deep; digits keep clear of each other.
bool holds(const HandSkeleton& skeleton, const Grasp& grasp) {
  constexpr double kDigitsMm = 7.0;
  if (grasp.thing.solids.empty()) return false;
  const Landmarks hand = posed(skeleton, grasp.hand);
  int touching = 0;
  for (int digit = 0; digit <= HandCapsule::kPalmCapsule; ++digit) {
    const double gap = gap_of_digit(hand, grasp, digit);
    if (gap < -kDeepestMm) return false;
    touching += gap < kTouchMm ? 1 : 0;
  }
  return touching >= 2 && worst_penetration_mm(hand) < kDigitsMm;
}

}  // namespace

std::span<const std::string_view> grasp_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const GraspKind& kind : kGrasps) all.push_back(kind.name);
    return all;
  }();
  return names;
}

double gap_to_thing_mm(const std::array<Point3, kSupersetSize>& landmarks, const Grasp& grasp) {
  double least = std::numeric_limits<double>::infinity();
  for (int digit = 0; digit <= HandCapsule::kPalmCapsule; ++digit)
    least = std::min(least, gap_of_digit(landmarks, grasp, digit));
  return least;
}

std::optional<Grasp> sampled_grasp(const HandSkeleton& skeleton, const std::vector<std::string>& names,
                                   Random& random) {
  constexpr int kGraspAttempts = 8;
  std::vector<const GraspKind*> kinds;
  for (const GraspKind& kind : kGrasps) {
    if (names.empty() || std::ranges::find(names, kind.name) != names.end()) kinds.push_back(&kind);
  }
  if (kinds.empty()) fail("grasps: none of the given names is one");
  for (int attempt = 0; attempt < kGraspAttempts; ++attempt) {
    const GraspKind& kind = *kinds[random.below(static_cast<std::uint32_t>(kinds.size()))];
    Grasp grasp = kind.make(skeleton, random);
    grasp.hand = clamped(grasp.hand);
    if (kind.closes) close_hand(skeleton, grasp);
    grasp.hand = clamped(grasp.hand);
    if (holds(skeleton, grasp)) return grasp;
  }
  return std::nullopt;
}

}  // namespace knuckle
