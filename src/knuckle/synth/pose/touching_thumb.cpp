// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/touching_thumb.h"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "knuckle/core/angle.h"
#include "knuckle/core/landmarks.h"
#include "knuckle/hand/adult_skeleton.h"

namespace knuckle {
namespace {

constexpr int kSteps = 40;
/// Deviation of each of a thumb's angles from where the hand had it: it reaches by its metacarpal.
constexpr std::array<double, kThumbAngleCount> kHabit = {22.0 * kDegree, 22.0 * kDegree, 14.0 * kDegree,
                                                         18.0 * kDegree, 7.0 * kDegree};

using ThumbRow = Eigen::Matrix<double, 1, kThumbAngleCount>;

/// Distance of the thumb's tip from what is asked for [mm], and its derivatives by the thumb's angles
/// [mm/rad].
struct Gap {
  double mm = 0.0;
  ThumbRow slope = ThumbRow::Zero();
};

Gap gap_of(const HandAngles& hand, const ThumbContact& contact) {
  LandmarkJacobian jacobian;
  const auto points = landmarks(adult_skeleton(), hand, RigidTransform::Identity(), &jacobian);
  const auto tip = static_cast<Eigen::Index>(Landmark::thumb_tip);
  const std::size_t joint = static_cast<std::size_t>(Landmark::index_mcp) + 4 * contact.finger + contact.bone;
  const Point3 touched = (1.0 - contact.along) * points[joint] + contact.along * points[joint + 1];
  const Eigen::Vector3d between = points[tip] - touched;
  const double length = between.norm();
  const Eigen::Vector3d direction =
      length > 0.0 ? Eigen::Vector3d(between / length) : Eigen::Vector3d::UnitZ();
  return {length - contact.distance_mm,
          direction.transpose() * jacobian.block<3, kThumbAngleCount>(3 * tip, 0)};
}

double cost_of(const HandAngles& hand, const HandAngles& habit, const ThumbContact& contact) {
  double cost = std::pow(gap_of(hand, contact).mm, 2);
  for (int i = 0; i < kThumbAngleCount; ++i) {
    cost += std::pow((hand.radians[i] - habit.radians[i]) / kHabit[i], 2);
  }
  return cost;
}

/// A step of Levenberg and Marquardt, `damping` times a habit's strength.
HandAngles stepped(const HandAngles& hand, const HandAngles& habit, const ThumbContact& contact,
                   double damping) {
  const Gap gap = gap_of(hand, contact);
  Eigen::Matrix<double, kThumbAngleCount, kThumbAngleCount> curvature = gap.slope.transpose() * gap.slope;
  Eigen::Matrix<double, kThumbAngleCount, 1> descent = -gap.mm * gap.slope.transpose();
  for (int i = 0; i < kThumbAngleCount; ++i) {
    const double strength = 1.0 / (kHabit[i] * kHabit[i]);
    curvature(i, i) += (1.0 + damping) * strength;
    descent[i] += (habit.radians[i] - hand.radians[i]) * strength;
  }
  const Eigen::Matrix<double, kThumbAngleCount, 1> change = curvature.ldlt().solve(descent);
  HandAngles next = hand;
  for (int i = 0; i < kThumbAngleCount; ++i) next.radians[i] += change[i];
  return clamped(next);
}

}  // namespace

HandAngles with_touching_thumb(const HandAngles& hand, const ThumbContact& contact) {
  const HandAngles habit = clamped(hand);
  HandAngles touching = habit;
  double cost = cost_of(touching, habit, contact);
  double damping = 1.0;
  for (int step = 0; step < kSteps; ++step) {
    const HandAngles next = stepped(touching, habit, contact, damping);
    const double next_cost = cost_of(next, habit, contact);
    const bool is_better = next_cost < cost;
    damping *= is_better ? 0.3 : 5.0;
    if (!is_better) continue;
    touching = next;
    cost = next_cost;
  }
  return touching;
}

double distance_from_contact_mm(const HandAngles& hand, const ThumbContact& contact) {
  return std::abs(gap_of(hand, contact).mm);
}

}  // namespace knuckle
