// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skeleton_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "knuckle/core/error.h"
#include "knuckle/hand/skeleton_energy.h"

namespace knuckle {
namespace {

using Points = std::array<Point3, kSupersetSize>;

constexpr double kFirstDamping = 1e-3;
constexpr double kLargestDamping = 1e8;
constexpr double kLeastGain = 1e-5;  ///< of the energy, relative; a smaller step is the last
constexpr std::size_t kFewestTargets = 3;

std::size_t known_count(const LandmarkTargets& targets) {
  return static_cast<std::size_t>(std::ranges::count_if(targets, is_known));
}

void check_arguments(const LandmarkTargets& targets, const HandSurface& surface,
                     const SkeletonFitOptions& options) {
  const auto check_above_0 = [](double value, const char* name) {
    if (!(value > 0.0) || !std::isfinite(value))
      fail("skeleton fit: {} is {}, expected above 0", name, value);
  };
  check_above_0(options.noise_mm, "noise_mm");
  check_above_0(options.posture_spread, "posture_spread");
  check_above_0(options.expected_rad, "expected_rad");
  check_above_0(options.surface_mm, "surface_mm");
  check_above_0(options.size, "size");
  for (const auto& digit : options.lengths) {
    for (const double length : digit) check_above_0(length, "lengths");
  }
  const auto check_not_below_0 = [](double value, const char* name) {
    if (!(value >= 0.0) || !std::isfinite(value))
      fail("skeleton fit: {} is {}, expected 0 or more", name, value);
  };
  check_not_below_0(options.bone_mm, "bone_mm");
  check_not_below_0(options.overlap_mm, "overlap_mm");
  check_not_below_0(options.size_spread, "size_spread");
  check_not_below_0(options.length_spread, "length_spread");
  if (options.most_steps < 1) fail("skeleton fit: most_steps is {}, expected 1 or more", options.most_steps);
  for (const LandmarkTarget& target : targets) {
    if (!(target.weight >= 0.0) || !std::isfinite(target.weight))
      fail("skeleton fit: a landmark's weight is {}, expected a finite number, 0 or more", target.weight);
    check_not_below_0(target.depth_weight, "depth_weight");
  }
  if (!std::ranges::all_of(surface.points, [](const Point3& point) { return point.allFinite(); }))
    fail("skeleton fit: a point of the surface is not finite");
}

/// Holds a parameter: it neither moves nor moves others.
void hold(int parameter, Linearised& at) {
  at.gradient[parameter] = 0.0;
  at.curvature.row(parameter).setZero();
  at.curvature.col(parameter).setZero();
  at.curvature(parameter, parameter) = 1.0;
}

/// Holds what an option says not to change.
void hold_what_is_given(const SkeletonFitOptions& options, Linearised& at) {
  if (options.size_spread == 0.0) hold(kSizeColumn, at);
  if (options.length_spread > 0.0) return;
  for (int column = kLengthColumn; column < kSkeletonUnknowns; ++column) hold(column, at);
}

/// Holds angles at a limit, also one that depends on other angles, that would have to go beyond it.
void hold_at_limits(const HandSkeleton& skeleton, const SkeletonPose& pose, Linearised& at) {
  constexpr double kLittle = 1e-6;  // [rad]
  for (int i = 0; i < kHandAngleCount; ++i) {
    HandAngles downhill = pose.angles;
    downhill.radians[i] -= std::copysign(kLittle, at.gradient[i]);
    const double allowed = clamped(downhill, skeleton.limits).radians[i];
    if (std::abs(allowed - downhill.radians[i]) > 0.5 * kLittle) hold(i, at);
  }
}

SkeletonStep damped_step(const Linearised& at, double damping) {
  auto damped = at.curvature;
  damped.diagonal() *= 1.0 + damping;
  damped.diagonal().array() += 1e-12;
  return damped.ldlt().solve(-at.gradient);
}

SkeletonFit descended(const HandSkeleton& skeleton, const SkeletonEnergy& energy,
                      const SkeletonFitOptions& options, const SkeletonPose& first) {
  SkeletonFit fit{.pose = first, .energy = energy.at(first)};
  double damping = kFirstDamping;
  while (fit.steps < options.most_steps) {
    Linearised at = energy.linearised(fit.pose);
    hold_what_is_given(options, at);
    hold_at_limits(skeleton, fit.pose, at);
    double gain = 0.0;
    for (; gain <= 0.0 && damping < kLargestDamping; damping *= 4.0) {
      const SkeletonPose next = stepped(skeleton, fit.pose, damped_step(at, damping));
      const double found = energy.at(next);
      gain = fit.energy - found;
      if (!(gain > 0.0)) {
        gain = 0.0;  // also where it is not a number
        continue;
      }
      fit.pose = next;
      fit.energy = found;
    }
    damping = std::max(damping / 16.0, 1e-9);
    if (gain <= 0.0) break;
    ++fit.steps;
    if (gain < kLeastGain * (1.0 + fit.energy)) break;
  }
  fit.rms_mm = energy.rms_mm(fit.pose);
  fit.gap_mm = energy.gap_mm(fit.pose);
  return fit;
}

/// The posture as a rigid body, of the size that is known, where it lies best on the targets.
SkeletonPose laid_on(const HandSkeleton& skeleton, const HandAngles& angles, const LandmarkTargets& targets,
                     const SkeletonFitOptions& options) {
  const SkeletonPose straight{clamped(angles, skeleton.limits), RigidTransform::Identity(), options.size,
                              options.lengths};
  const Points points = landmarks(skeleton, straight);
  Point3 from_mean = Point3::Zero();
  Point3 to_mean = Point3::Zero();
  double weights = 0.0;
  for (int i = 0; i < kSupersetSize; ++i) {
    if (!is_known(targets[i])) continue;
    from_mean += targets[i].weight * points[i];
    to_mean += targets[i].weight * targets[i].point;
    weights += targets[i].weight;
  }
  from_mean /= weights;
  to_mean /= weights;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int i = 0; i < kSupersetSize; ++i) {
    if (is_known(targets[i]))
      covariance += targets[i].weight * (targets[i].point - to_mean) * (points[i] - from_mean).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const bool is_reflected = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0;
  const Eigen::Vector3d signs(1.0, 1.0, is_reflected ? -1.0 : 1.0);
  SkeletonPose laid = straight;
  laid.camera_from_hand.linear() = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  laid.camera_from_hand.translation() = to_mean - laid.camera_from_hand.linear() * from_mean;
  return laid;
}

SkeletonPose first_pose(const HandSkeleton& skeleton, const SkeletonEnergy& energy,
                        const LandmarkTargets& targets, const SkeletonFitOptions& options) {
  SkeletonPose best;
  double lowest = std::numeric_limits<double>::infinity();
  for (const HandAngles& posture :
       {resting_hand(), bent_hand(0.2, 1.4), bent_hand(1.2, 0.3), bent_hand(1.2, 1.4)}) {
    const SkeletonPose laid = laid_on(skeleton, posture, targets, options);
    const double found = energy.at(laid);
    if (found >= lowest) continue;
    lowest = found;
    best = laid;
  }
  return best;
}

}  // namespace

Points landmarks(const HandSkeleton& skeleton, const SkeletonPose& pose) {
  Points points = landmarks(skeleton, pose.angles, pose.camera_from_hand);
  const Point3 wrist = pose.camera_from_hand.translation();
  for (Point3& point : points) point = wrist + pose.size * (point - wrist);
  const Points of_skeleton = points;
  for (int digit = 0; digit < 5; ++digit) {
    for (int bone = 0; bone < 3; ++bone) {
      const auto from = static_cast<std::size_t>(landmark_of_digit(digit, bone));
      const auto to = static_cast<std::size_t>(landmark_of_digit(digit, bone + 1));
      points[to] = points[from] + pose.lengths[digit][bone] * (of_skeleton[to] - of_skeleton[from]);
    }
  }
  return points;
}

std::optional<SkeletonFit> fit_skeleton(const HandSkeleton& skeleton, const LandmarkTargets& targets,
                                        const SkeletonFitOptions& options,
                                        const std::optional<SkeletonPose>& start,
                                        const HandSurface& surface) {
  check_arguments(targets, surface, options);
  if (known_count(targets) < kFewestTargets) return std::nullopt;
  const SkeletonEnergy energy(skeleton, targets, surface, options);
  SkeletonPose first = start ? *start : first_pose(skeleton, energy, targets, options);
  first.angles = clamped(first.angles, skeleton.limits);
  if (options.size_spread == 0.0) first.size = options.size;
  if (options.length_spread == 0.0) first.lengths = options.lengths;
  return descended(skeleton, energy, options, first);
}

}  // namespace knuckle
