// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skeleton_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "knuckle/core/error.h"
#include "knuckle/core/portable_math.h"

namespace knuckle {
namespace {

using Points = std::array<Point3, kSupersetSize>;
constexpr int kParameters = kHandAngleCount + 7;
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

constexpr double kFirstDamping = 1e-3;
constexpr double kLargestDamping = 1e8;
constexpr double kLeastGain = 1e-6;  ///< of the energy, relative; a smaller step is the last
constexpr std::size_t kFewestTargets = 3;

/// A hand that does nothing: fingers a little bent, the thumb beside and before them.
HandAngles bent(double mcp, double pip) {
  using enum HandAngle;
  HandAngles angles;
  angles[thumb_radial] = 0.4;
  angles[thumb_palmar] = 0.5;
  angles[thumb_mcp] = angles[thumb_ip] = 0.25;
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    angles[names.mcp] = mcp;
    angles[names.pip] = pip;
    angles[names.dip] = coupled_dip(pip);
  }
  return angles;
}
HandAngles resting() {
  return bent(0.3, 0.4);
}

bool is_known(const LandmarkTarget& target) {
  return target.weight > 0.0 && target.point.allFinite();
}

std::size_t known_count(const LandmarkTargets& targets) {
  return static_cast<std::size_t>(std::ranges::count_if(targets, is_known));
}

void check_arguments(const LandmarkTargets& targets, const SkeletonFitOptions& options) {
  const auto check_above_0 = [](double value, const char* name) {
    if (!(value > 0.0) || !std::isfinite(value))
      fail("skeleton fit: {} is {}, expected above 0", name, value);
  };
  check_above_0(options.noise_mm, "noise_mm");
  check_above_0(options.posture_rad, "posture_rad");
  if (!(options.size_spread >= 0.0) || !std::isfinite(options.size_spread))
    fail("skeleton fit: size_spread is {}, expected 0 or more", options.size_spread);
  if (options.most_steps < 1) fail("skeleton fit: most_steps is {}, expected 1 or more", options.most_steps);
  for (const LandmarkTarget& target : targets) {
    if (!(target.weight >= 0.0) || !std::isfinite(target.weight))
      fail("skeleton fit: a landmark's weight is {}, expected a finite number, 0 or more", target.weight);
  }
}

/// Landmarks and derivatives in the parameters of LandmarkJacobian; the last is the logarithm of the size.
Points posed(const HandSkeleton& skeleton, const SkeletonPose& pose, LandmarkJacobian* jacobian) {
  Points points = landmarks(skeleton, pose.angles, pose.camera_from_hand, jacobian);
  const Point3 wrist = pose.camera_from_hand.translation();
  for (Point3& point : points) point = wrist + pose.size * (point - wrist);
  if (jacobian != nullptr) {
    jacobian->leftCols<kShiftColumn>() *= pose.size;
    jacobian->col(kSizeColumn) *= pose.size;
  }
  return points;
}

/// What is to be made small, and its first and (as Gauss and Newton have it) second derivatives.
struct Linearised {
  double energy = 0.0;
  Vector gradient = Vector::Zero();
  Matrix curvature = Matrix::Zero();
};

class Energy {
 public:
  Energy(const HandSkeleton& skeleton, const LandmarkTargets& targets, const SkeletonFitOptions& options)
      : skeleton_(skeleton), targets_(targets), options_(options), rest_(resting()) {}

  double at(const SkeletonPose& pose) const {
    const Points points = posed(skeleton_, pose, nullptr);
    double energy = prior_of(pose);
    for (int i = 0; i < kSupersetSize; ++i) {
      if (is_known(targets_[i])) energy += 0.5 * weight(i) * (points[i] - targets_[i].point).squaredNorm();
    }
    return energy;
  }

  Linearised linearised(const SkeletonPose& pose) const {
    LandmarkJacobian jacobian;
    const Points points = posed(skeleton_, pose, &jacobian);
    Linearised result;
    result.energy = prior_of(pose);
    for (int i = 0; i < kSupersetSize; ++i) {
      if (!is_known(targets_[i])) continue;
      const Point3 residual = points[i] - targets_[i].point;
      const Eigen::Matrix<double, 3, kParameters> rows = jacobian.middleRows<3>(3 * i);
      result.energy += 0.5 * weight(i) * residual.squaredNorm();
      result.gradient += weight(i) * rows.transpose() * residual;
      result.curvature += weight(i) * rows.transpose() * rows;
    }
    add_prior(pose, result);
    return result;
  }

  double rms_mm(const SkeletonPose& pose) const {
    const Points points = posed(skeleton_, pose, nullptr);
    double sum = 0.0;
    double weights = 0.0;
    for (int i = 0; i < kSupersetSize; ++i) {
      if (!is_known(targets_[i])) continue;
      sum += targets_[i].weight * (points[i] - targets_[i].point).squaredNorm();
      weights += targets_[i].weight;
    }
    return std::sqrt(sum / weights);
  }

 private:
  double weight(int landmark) const {
    return targets_[landmark].weight / (options_.noise_mm * options_.noise_mm);
  }

  double prior_of(const SkeletonPose& pose) const {
    double sum = 0.0;
    for (int i = 0; i < kHandAngleCount; ++i) {
      const double away = (pose.angles.radians[i] - rest_.radians[i]) / options_.posture_rad;
      sum += away * away;
    }
    if (options_.size_spread > 0.0) {
      const double away = portable_log(pose.size) / options_.size_spread;
      sum += away * away;
    }
    return 0.5 * sum;
  }

  void add_prior(const SkeletonPose& pose, Linearised& result) const {
    const double of_angles = 1.0 / (options_.posture_rad * options_.posture_rad);
    for (int i = 0; i < kHandAngleCount; ++i) {
      result.gradient[i] += of_angles * (pose.angles.radians[i] - rest_.radians[i]);
      result.curvature(i, i) += of_angles;
    }
    if (options_.size_spread == 0.0) return;
    const double of_size = 1.0 / (options_.size_spread * options_.size_spread);
    result.gradient[kSizeColumn] += of_size * portable_log(pose.size);
    result.curvature(kSizeColumn, kSizeColumn) += of_size;
  }

  const HandSkeleton& skeleton_;
  const LandmarkTargets& targets_;
  const SkeletonFitOptions& options_;
  HandAngles rest_;
};

/// Holds a parameter: it neither moves nor moves others.
void hold(int parameter, Linearised& at) {
  at.gradient[parameter] = 0.0;
  at.curvature.row(parameter).setZero();
  at.curvature.col(parameter).setZero();
  at.curvature(parameter, parameter) = 1.0;
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

SkeletonPose stepped(const HandSkeleton& skeleton, const SkeletonPose& pose, const Vector& step) {
  SkeletonPose next = pose;
  for (int i = 0; i < kHandAngleCount; ++i) next.angles.radians[i] += step[i];
  next.angles = clamped(next.angles, skeleton.limits);
  next.camera_from_hand =
      moved(pose.camera_from_hand, step.segment<3>(kTurnColumn), step.segment<3>(kShiftColumn));
  next.size = pose.size * portable_exp(std::clamp(step[kSizeColumn], -0.5, 0.5));
  return next;
}

Vector damped_step(const Linearised& at, double damping) {
  Matrix damped = at.curvature;
  damped.diagonal() *= 1.0 + damping;
  damped.diagonal().array() += 1e-12;
  return damped.ldlt().solve(-at.gradient);
}

SkeletonFit descended(const HandSkeleton& skeleton, const Energy& energy, const SkeletonFitOptions& options,
                      const SkeletonPose& first) {
  SkeletonFit fit{first, 0.0, energy.at(first), 0};
  double damping = kFirstDamping;
  while (fit.steps < options.most_steps) {
    Linearised at = energy.linearised(fit.pose);
    if (options.size_spread == 0.0) hold(kSizeColumn, at);
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
  return fit;
}

/// The posture as a rigid body, of size 1, where it lies best on the targets.
SkeletonPose laid_on(const HandSkeleton& skeleton, const HandAngles& angles, const LandmarkTargets& targets) {
  const SkeletonPose straight{clamped(angles, skeleton.limits), RigidTransform::Identity(), 1.0};
  const Points points = posed(skeleton, straight, nullptr);
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

SkeletonPose first_pose(const HandSkeleton& skeleton, const Energy& energy, const LandmarkTargets& targets) {
  SkeletonPose best;
  double lowest = std::numeric_limits<double>::infinity();
  for (const HandAngles& posture : {resting(), bent(0.2, 1.4), bent(1.2, 0.3), bent(1.2, 1.4)}) {
    const SkeletonPose laid = laid_on(skeleton, posture, targets);
    const double found = energy.at(laid);
    if (found >= lowest) continue;
    lowest = found;
    best = laid;
  }
  return best;
}

}  // namespace

Points landmarks(const HandSkeleton& skeleton, const SkeletonPose& pose) {
  return posed(skeleton, pose, nullptr);
}

std::optional<SkeletonFit> fit_skeleton(const HandSkeleton& skeleton, const LandmarkTargets& targets,
                                        const SkeletonFitOptions& options,
                                        const std::optional<SkeletonPose>& start) {
  check_arguments(targets, options);
  if (known_count(targets) < kFewestTargets) return std::nullopt;
  const Energy energy(skeleton, targets, options);
  SkeletonPose first = start ? *start : first_pose(skeleton, energy, targets);
  first.angles = clamped(first.angles, skeleton.limits);
  if (options.size_spread == 0.0) first.size = 1.0;
  return descended(skeleton, energy, options, first);
}

}  // namespace knuckle
