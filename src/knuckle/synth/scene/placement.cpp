// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "knuckle/camera/projection.h"
#include "knuckle/core/angle.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/hand/hand_rig.h"
#include "knuckle/hand/rotation_between.h"

namespace knuckle {
namespace {

using Eigen::Vector3d;

constexpr int kAttempts = 200;
/// A hand nearer than this fills the image [mm].
constexpr double kTooNear = 120.0;
/// In a frame whose hand may be cut, this part of its landmarks may lie outside.
constexpr double kCutShare = 0.4;

/// A part of the body as a ball, for a quick look at what hides what [mm].
struct BodyBall {
  std::string_view from;  ///< the bone at whose head it lies
  std::string_view to;    ///< and the one it lies towards
  double share;           ///< how far
  double radius;
  bool is_forearm;
};

constexpr BodyBall kBalls[] = {
    {"head", "head", 0.0, 105, false},
    {"neck01", "neck01", 0.0, 75, false},
    {"spine01", "spine01", 0.0, 140, false},
    {"spine02", "spine02", 0.0, 150, false},
    {"spine03", "spine03", 0.0, 150, false},
    {"spine05", "spine05", 0.0, 160, false},
    {"upperarm01.L", "upperarm01.L", 0.0, 70, false},
    {"lowerarm01.L", "lowerarm01.L", 0.0, 50, false},
    {"wrist.L", "wrist.L", 0.0, 60, false},
    {"upperarm01.R", "upperarm01.R", 0.0, 65, false},
    {"upperarm01.R", "lowerarm01.R", 0.5, 50, false},
    {"lowerarm01.R", "lowerarm01.R", 0.0, 45, true},
    {"lowerarm02.R", "wrist.R", 0.0, 42, true},
    {"lowerarm02.R", "wrist.R", 0.5, 35, true},
};

struct Ball {
  Vector3d centre;
  double radius;
  bool is_forearm;
};

std::vector<Ball> balls_of(const BodyRig& rig, const BodyPose& pose) {
  const Body& body = *rig.person().body;
  const std::vector<Eigen::Matrix4f> transforms = bone_transforms(rig.person(), pose);
  const auto head_of = [&](std::string_view name) -> std::optional<Vector3d> {
    const auto found = std::ranges::find(body.names, name);
    if (found == body.names.end()) return std::nullopt;
    const auto bone = found - body.names.begin();
    return (transforms[bone] * rig.person().joints[bone].homogeneous()).head<3>().cast<double>();
  };
  std::vector<Ball> balls;
  for (const BodyBall& ball : kBalls) {
    const auto from = head_of(ball.from);
    const auto to = head_of(ball.to);
    if (from && to) balls.push_back({*from + ball.share * (*to - *from), ball.radius, ball.is_forearm});
  }
  return balls;
}

bool is_in_view(const Ball& ball, const Camera& camera) {
  if (ball.centre.z() + ball.radius <= 0.0) return false;
  const bool projective = camera.model == CameraModel::projective;
  const double scale = projective ? 1.0 / std::max(ball.centre.z(), ball.radius) : 1.0;
  const double u = camera.fx * ball.centre.x() * scale + camera.cx;
  const double v = camera.fy * ball.centre.y() * scale + camera.cy;
  const double radius = std::abs(camera.fx) * ball.radius * scale;
  return u > -radius && u < camera.width + radius && v > -radius && v < camera.height + radius;
}

double outside_px(const ImagePoint& point, const Camera& camera) {
  if (point.is_missing()) return camera.width;
  return std::max({-point.u, point.u - (camera.width - 1), -point.v, point.v - (camera.height - 1), 0.0});
}

double landmark_violation(const std::array<Point3, kSupersetSize>& landmarks, const Camera& camera,
                          double allowed_outside) {
  const Projection projection(camera);
  std::vector<double> outside;
  double too_near = 0.0;
  for (const Point3& landmark : landmarks) {
    outside.push_back(outside_px(projection.to_image(landmark), camera));
    too_near = std::max(too_near, kTooNear - landmark.z());
  }
  std::ranges::sort(outside);
  const auto counted = static_cast<std::size_t>((1.0 - allowed_outside) * (kSupersetSize - 1));
  return outside[counted] + too_near;
}

/// From where the camera looks.
enum class View : std::uint8_t { facing, shoulder, free, above, around, eyes };

View sampled_view_kind(const PlacementOptions& options, Random& random) {
  const std::array<double, 6> shares = {options.facing_share, options.shoulder_share, options.free_share,
                                        options.above_share,  options.around_share,   options.eyes_share};
  std::array<double, 6> sums{};
  std::partial_sum(shares.begin(), shares.end(), sums.begin());
  const double drawn = random.uniform() * sums.back();
  const auto kind = std::ranges::upper_bound(sums, drawn) - sums.begin();
  return static_cast<View>(std::min<std::ptrdiff_t>(kind, sums.size() - 1));
}

/// Turns the person as seen by the camera: x left, y up, z front of the body to x right, y down, z forward.
Eigen::Matrix3d sampled_view(View view, const PlacementOptions& options, Random& random) {
  if (view == View::free) {
    Eigen::Quaterniond any(random.normal(), random.normal(), random.normal(), random.normal());
    return any.normalized().toRotationMatrix();
  }
  Eigen::Matrix3d facing = Vector3d(1, -1, -1).asDiagonal();
  if (view == View::shoulder || view == View::eyes) facing = Vector3d(-1, -1, 1).asDiagonal();
  const auto turn = [](double angle, const Vector3d& axis) {
    return rotation_about(angle, axis).toRotationMatrix();
  };
  if (view == View::above || view == View::around) {
    const Eigen::Matrix3d yaw = turn(random.uniform(-180.0, 180.0) * kDegree, Vector3d::UnitY());
    const double pitch_deg = view == View::above ? random.uniform(50.0, 95.0) : random.uniform(-10.0, 50.0);
    const Eigen::Matrix3d roll = turn(options.roll_deg * kDegree * random.normal(), Vector3d::UnitZ());
    return roll * turn(pitch_deg * kDegree, Vector3d::UnitX()) * yaw * facing;
  }
  const Eigen::Matrix3d yaw = turn(options.yaw_deg * kDegree * random.normal(), Vector3d::UnitY());
  const Eigen::Matrix3d pitch = turn(options.pitch_deg * kDegree * random.normal(), Vector3d::UnitX());
  const Eigen::Matrix3d roll = turn(options.roll_deg * kDegree * random.normal(), Vector3d::UnitZ());
  return roll * pitch * yaw * facing;
}

/// Where a camera at a person's eyes is, in body axes [mm].
Vector3d eyes_of(const BodyRig& rig) {
  const Body& body = *rig.person().body;
  const auto found = std::ranges::find(body.names, "head");
  if (found == body.names.end()) return Vector3d(0.0, 400.0, 0.0);
  constexpr double kUpMm = 70.0;
  constexpr double kForwardMm = 130.0;  // before the forehead
  return rig.person().joints[found - body.names.begin()].cast<double>() + Vector3d(0.0, kUpMm, kForwardMm);
}

/// Turns the head of a person who looks along `view` so that the palm is seen where `seen_palm` is.
Eigen::Isometry3f view_from_eyes(const BodyRig& rig, const Point3& palm, const Eigen::Matrix3d& view,
                                 const Point3& seen_palm) {
  const Vector3d eyes = eyes_of(rig);
  const Eigen::Matrix3d turn =
      rotation_between(view * (palm - eyes), seen_palm).normalized().toRotationMatrix() * view;
  Eigen::Isometry3f camera_from_body = Eigen::Isometry3f::Identity();
  camera_from_body.linear() = turn.cast<float>();
  camera_from_body.translation() = (turn * -eyes).cast<float>();
  return camera_from_body;
}

/// The options of a view from the eyes: chest and arm may be nearer than the hand.
PlacementOptions options_of_view(View view, PlacementOptions options) {
  if (view != View::eyes) return options;
  constexpr double kAnywhere = 1000.0;
  options.trunk_gap_mm = -kAnywhere;
  options.forearm_margin_mm = kAnywhere;
  return options;
}

/// How deep the hand is in the chest, neck or head [mm]. Seen from elsewhere they have to lie behind it
/// anyway.
double depth_in_trunk(const BodyRig& rig, const BodyPose& pose) {
  constexpr double kHandMm = 40.0;
  constexpr double kTrunkMm = 100.0;  // balls of at least this radius are trunk or head
  double deepest = 0.0;
  const std::array<Point3, kSupersetSize> landmarks = rig.landmarks(pose);
  for (const Ball& ball : balls_of(rig, pose)) {
    if (ball.radius < kTrunkMm) continue;
    for (const Point3& landmark : landmarks)
      deepest = std::max(deepest, ball.radius + kHandMm - (landmark - ball.centre).norm());
  }
  return deepest;
}

/// A point for the palm: normal around the image's centre, depth uniform.
Point3 sampled_palm(const Camera& camera, const PlacementOptions& options, Random& random) {
  const double u = 0.5 * (camera.width - 1) + options.off_centre * camera.width * random.normal();
  const double v = 0.5 * (camera.height - 1) + options.off_centre * camera.height * random.normal();
  const double depth = random.uniform(options.nearest_mm, options.farthest_mm);
  return Projection(camera).to_camera(
      ImagePoint{std::clamp(u, 0.0, camera.width - 1.0), std::clamp(v, 0.0, camera.height - 1.0), depth});
}

}  // namespace

ArmAngles sampled_arm(const PlacementOptions& options, Random& random) {
  const std::vector<AngleRange>& ranges = arm_ranges();
  std::vector<double> values;
  for (const AngleRange& range : ranges) values.push_back(random.uniform(range.low, range.high));
  ArmAngles arm = ArmAngles::from_values(values);
  arm.wrist_flexion =
      std::clamp(options.wrist_deg * kDegree * random.normal(), ranges[5].low, ranges[5].high);
  arm.wrist_deviation =
      std::clamp(0.4 * options.wrist_deg * kDegree * random.normal(), ranges[6].low, ranges[6].high);
  return arm;
}

double violation(const BodyRig& rig, const BodyPose& pose, const Camera& camera,
                 const PlacementOptions& options, double allowed_outside) {
  const std::array<Point3, kSupersetSize> landmarks = rig.landmarks(pose);
  double total = landmark_violation(landmarks, camera, allowed_outside);
  double nearest = std::numeric_limits<double>::infinity();
  for (const Point3& landmark : landmarks) nearest = std::min(nearest, landmark.z());
  const double behind_trunk = landmarks[static_cast<std::size_t>(Landmark::palm)].z() + options.trunk_gap_mm;
  const double behind_forearm = nearest - options.forearm_margin_mm;
  for (const Ball& ball : balls_of(rig, pose)) {
    const double needed = ball.is_forearm ? behind_forearm : behind_trunk;
    const double lacking = needed - (ball.centre.z() - ball.radius);
    if (lacking > 0.0 && is_in_view(ball, camera)) total += lacking;
  }
  return total;
}

double presentation_violation(const std::array<Point3, kSupersetSize>& landmarks,
                              const PlacementOptions& options) {
  const Eigen::Matrix3d axes = hand_axes(landmarks);
  const Vector3d forward = axes.col(1);
  const Vector3d palmar = axes.col(2);
  const Vector3d to_camera = -landmarks[static_cast<std::size_t>(Landmark::palm)].normalized();
  const double palm = portable_acos(std::clamp(palmar.dot(to_camera), -1.0, 1.0)) / kDegree;
  const double upright = std::abs(portable_atan2(forward.x(), -forward.y())) / kDegree;
  return std::max(palm - options.palm_deg, 0.0) + std::max(upright - options.upright_deg, 0.0);
}

PlacedPosture sampled_placement(const BodyRig& rig, const HandAngles& hand, const Camera& camera,
                                const PlacementOptions& options, Random& random) {
  const double allowed_outside = random.uniform() < options.border_share ? kCutShare : 0.0;
  const bool is_presented = random.uniform() < options.presented_share;
  // Drawn once where some views seldom succeed, so that they come as often as asked for; else with each
  // attempt, as manifests were rendered that know three views.
  std::optional<View> settled_view;
  if (options.above_share + options.around_share + options.eyes_share > 0.0)
    settled_view = sampled_view_kind(options, random);
  PlacedPosture best;
  double least = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kAttempts && least > 0.0; ++attempt) {
    PlacedPosture placed{{hand, sampled_arm(options, random)}, Eigen::Isometry3f::Identity()};
    const View view = settled_view ? *settled_view : sampled_view_kind(options, random);
    const Eigen::Matrix3d turn = sampled_view(view, options, random);
    if (view != View::eyes) placed.camera_from_body.linear() = turn.cast<float>();
    BodyPose pose = rig.pose(placed.posture, placed.camera_from_body);
    const Point3 palm = rig.landmarks(pose)[static_cast<std::size_t>(Landmark::palm)];
    const Point3 seen_palm = sampled_palm(camera, options, random);
    if (view == View::eyes) {
      placed.camera_from_body = view_from_eyes(rig, palm, turn, seen_palm);
    } else {
      placed.camera_from_body.translation() = (seen_palm - palm).cast<float>();
    }
    pose.camera_from_body = placed.camera_from_body;
    double wrong =
        is_presented && view != View::eyes ? presentation_violation(rig.landmarks(pose), options) : 0.0;
    if (wrong < least) wrong += violation(rig, pose, camera, options_of_view(view, options), allowed_outside);
    if (wrong < least && view == View::eyes) wrong += depth_in_trunk(rig, pose);
    if (wrong < least) {
      least = wrong;
      best = placed;
    }
  }
  return best;
}

}  // namespace knuckle
