// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

/// Turns the person as seen by the camera: x left, y up, z front of the body to x right, y down, z forward.
Eigen::Matrix3d sampled_view(const PlacementOptions& options, Random& random) {
  const double kind = random.uniform() * (options.facing_share + options.shoulder_share + options.free_share);
  if (kind >= options.facing_share + options.shoulder_share) {
    Eigen::Quaterniond any(random.normal(), random.normal(), random.normal(), random.normal());
    return any.normalized().toRotationMatrix();
  }
  Eigen::Matrix3d facing = Vector3d(1, -1, -1).asDiagonal();
  if (kind >= options.facing_share) facing = Vector3d(-1, -1, 1).asDiagonal();
  const auto turn = [&](double deviation_deg, const Vector3d& axis) {
    return rotation_about(deviation_deg * kDegree * random.normal(), axis).toRotationMatrix();
  };
  const Eigen::Matrix3d yaw = turn(options.yaw_deg, Vector3d::UnitY());
  const Eigen::Matrix3d pitch = turn(options.pitch_deg, Vector3d::UnitX());
  const Eigen::Matrix3d roll = turn(options.roll_deg, Vector3d::UnitZ());
  return roll * pitch * yaw * facing;
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

void PlacementOptions::visit(OptionVisitor& visitor) {
  visitor.real("facing_share", facing_share, at_least(0));
  visitor.real("shoulder_share", shoulder_share, at_least(0));
  visitor.real("free_share", free_share, at_least(0));
  visitor.real("yaw_deg", yaw_deg, closed(0, 180));
  visitor.real("pitch_deg", pitch_deg, closed(0, 90));
  visitor.real("roll_deg", roll_deg, closed(0, 180));
  visitor.real("nearest_mm", nearest_mm, closed(100, 5000));
  visitor.real("farthest_mm", farthest_mm, closed(100, 5000));
  visitor.real("off_centre", off_centre, closed(0, 1));
  visitor.real("border_share", border_share, closed(0, 1));
  visitor.real("trunk_gap_mm", trunk_gap_mm, closed(-1000, 1000));
  visitor.real("forearm_margin_mm", forearm_margin_mm, closed(0, 1000));
  visitor.real("wrist_deg", wrist_deg, closed(0, 90));
  visitor.real("presented_share", presented_share, closed(0, 1));
  visitor.real("palm_deg", palm_deg, open_closed(0, 180));
  visitor.real("upright_deg", upright_deg, open_closed(0, 180));
}

void check(const PlacementOptions& options, std::string_view what) {
  check_options(options, what);
  if (options.facing_share + options.shoulder_share + options.free_share <= 0.0) {
    fail("{}: facing_share, shoulder_share and free_share are all 0; expected one above 0", what);
  }
  if (options.nearest_mm > options.farthest_mm) {
    fail("{}: nearest_mm is {}, expected at most farthest_mm, {}", what, options.nearest_mm,
         options.farthest_mm);
  }
}

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
  PlacedPosture best;
  double least = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < kAttempts && least > 0.0; ++attempt) {
    PlacedPosture placed{{hand, sampled_arm(options, random)}, Eigen::Isometry3f::Identity()};
    placed.camera_from_body.linear() = sampled_view(options, random).cast<float>();
    BodyPose pose = rig.pose(placed.posture, placed.camera_from_body);
    const Point3 palm = rig.landmarks(pose)[static_cast<std::size_t>(Landmark::palm)];
    placed.camera_from_body.translation() = (sampled_palm(camera, options, random) - palm).cast<float>();
    pose.camera_from_body = placed.camera_from_body;
    double wrong = is_presented ? presentation_violation(rig.landmarks(pose), options) : 0.0;
    if (wrong < least) wrong += violation(rig, pose, camera, options, allowed_outside);
    if (wrong < least) {
      least = wrong;
      best = placed;
    }
  }
  return best;
}

}  // namespace knuckle
