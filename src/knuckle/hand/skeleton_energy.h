// SPDX-License-Identifier: Apache-2.0
// What `fit_skeleton` makes small; it and the tests alone include this.
#pragma once

#include <Eigen/Core>

#include "knuckle/hand/posture_prior.h"
#include "knuckle/hand/skeleton_fit.h"
#include "knuckle/hand/surface_contacts.h"

namespace knuckle {

/// The unknowns: the columns of LandmarkJacobian, with the logarithm of the size in place of the size; after
/// them the logarithms of the digits' lengths, in the order of DigitNumbers.
inline constexpr int kLengthColumn = kHandAngleCount + 7;
/// How many there are.
inline constexpr int kSkeletonUnknowns = kLengthColumn + 15;
using SkeletonStep = Eigen::Matrix<double, kSkeletonUnknowns, 1>;

/// An energy with its first and, as Gauss and Newton have it, second derivatives at a step of 0.
struct Linearised {
  double energy = 0.0;
  SkeletonStep gradient = SkeletonStep::Zero();
  /// The lower triangle counts.
  Eigen::Matrix<double, kSkeletonUnknowns, kSkeletonUnknowns> curvature =
      Eigen::Matrix<double, kSkeletonUnknowns, kSkeletonUnknowns>::Zero();
};

/// Derivatives of the landmarks by the unknowns; rows as in LandmarkJacobian.
using PoseJacobian = Eigen::Matrix<double, 3 * kSupersetSize, kSkeletonUnknowns, Eigen::DontAlign>;
/// The landmarks of a pose, and these derivatives.
std::array<Point3, kSupersetSize> landmarks(const HandSkeleton& skeleton, const SkeletonPose& pose,
                                            PoseJacobian& jacobian);

/// A hand that does nothing: fingers a little bent, the thumb beside and before them.
HandAngles bent_hand(double mcp, double pip);
/// One of the postures that a search begins with.
inline HandAngles resting_hand() {
  return bent_hand(0.3, 0.4);
}

/// Whether a target says anything.
inline bool is_known(const LandmarkTarget& target) {
  return target.weight > 0.0 && target.point.allFinite();
}

/// How little a pose agrees with landmarks, a surface and what is known of hands: the negative logarithm of
/// its posterior probability. What is given has to outlive it.
class SkeletonEnergy {
 public:
  SkeletonEnergy(const HandSkeleton& skeleton, const LandmarkTargets& targets, const HandSurface& surface,
                 const SkeletonFitOptions& options);

  double at(const SkeletonPose& pose) const;
  Linearised linearised(const SkeletonPose& pose) const;
  /// Of the weighted distances to the targets.
  double rms_mm(const SkeletonPose& pose) const;
  /// Mean distance of the surface's points from the skin, none more than 8 mm; NaN without points.
  double gap_mm(const SkeletonPose& pose) const;

 private:
  double weight(std::size_t landmark) const;
  double prior_of(const SkeletonPose& pose) const;
  void add_prior(const SkeletonPose& pose, Linearised& result) const;
  /// Calls `visit` with the two landmarks of each bone of the digits whose ends are known, and its weight.
  template <class Visit>
  void for_each_bone(const Visit& visit) const;
  /// How much a bone differs from what lies between its targets [mm].
  Eigen::Vector3d bone_miss(const std::array<Point3, kSupersetSize>& points, std::size_t from,
                            std::size_t to) const;
  /// Calls `visit` with each two bones that run into one another too deep, by how much [mm], and its weight.
  template <class Visit>
  void for_each_overlap(const std::array<Point3, kSupersetSize>& points, const Visit& visit) const;
  template <class Visit>
  void for_each_contact(const std::array<Point3, kSupersetSize>& points, double size,
                        const Visit& visit) const;

  const HandSkeleton& skeleton_;
  const LandmarkTargets& targets_;
  const HandSurface& surface_;
  const SkeletonFitOptions& options_;
  const PosturePrior& postures_ = sampled_postures();
  double palm_mm_;  // from the wrist to the middle MCP
};

/// The pose after a step, within the skeleton's limits.
SkeletonPose stepped(const HandSkeleton& skeleton, const SkeletonPose& pose, const SkeletonStep& step);

}  // namespace knuckle
