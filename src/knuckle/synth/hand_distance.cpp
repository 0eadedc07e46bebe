// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/hand_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "knuckle/core/error.h"
#include "knuckle/synth/hand_rig.h"

namespace knuckle {
namespace {

using JointMatrix = Eigen::Matrix3Xd;

// Places in HandJoints.
constexpr int kWrist = 0;
constexpr int kIndexMcp = 5;
constexpr int kMiddleMcp = 9;
constexpr int kLittleMcp = 17;

JointMatrix matrix_of(const HandJoints& hand) {
  JointMatrix matrix(3, kHandJoints);
  for (int k = 0; k < kHandJoints; ++k) matrix.col(k) = hand[k];
  return matrix;
}

/// A hand's shape: centred, of size 1, turned to the axes of its palm. Relative turns of two such shapes are
/// then far below half a turn, as HandSet::nearest needs.
struct Shape {
  JointMatrix joints;
  double size_mm;
};

Shape shape_of(const HandJoints& hand) {
  JointMatrix joints = matrix_of(hand);
  if (!joints.allFinite()) fail("hand shape: a joint is not finite");
  const Eigen::Matrix3d axes = hand_axes(hand[kWrist], hand[kIndexMcp], hand[kMiddleMcp], hand[kLittleMcp]);
  joints.colwise() -= joints.rowwise().mean().eval();
  const double size = joints.norm();
  if (!(size > 0.0) || !axes.allFinite()) fail("hand shape: joints that coincide have no shape");
  return {axes.transpose() * joints / size, size};
}

}  // namespace

HandJoints hand_joints(const std::array<Point3, kSupersetSize>& landmarks) {
  static_assert(static_cast<int>(Landmark::palm) == 1 && kHandJoints == kSupersetSize - 1);
  HandJoints joints;
  joints[0] = landmarks[0];
  std::copy(landmarks.begin() + 2, landmarks.end(), joints.begin() + 1);
  return joints;
}

HandJoints aligned_to(const HandJoints& target, const HandJoints& hand) {
  const JointMatrix to = matrix_of(target);
  const JointMatrix from = matrix_of(hand);
  const Eigen::Vector3d to_centre = to.rowwise().mean();
  const Eigen::Vector3d from_centre = from.rowwise().mean();
  const JointMatrix to_shape = to.colwise() - to_centre;
  const JointMatrix from_shape = from.colwise() - from_centre;
  const Eigen::Matrix3d products = to_shape * from_shape.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(products, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handedness = svd.matrixU().determinant() * svd.matrixV().determinant();
  const Eigen::Vector3d signs(1.0, 1.0, handedness < 0.0 ? -1.0 : 1.0);  // a rotation, not a mirror
  const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  const double scale = signs.dot(svd.singularValues()) / from_shape.squaredNorm();
  const JointMatrix moved = (scale * rotation * from_shape).colwise() + to_centre;
  HandJoints aligned;
  for (int k = 0; k < kHandJoints; ++k) aligned[k] = moved.col(k);
  return aligned;
}

double mean_distance_mm(const HandJoints& a, const HandJoints& b) {
  return (matrix_of(a) - matrix_of(b)).colwise().norm().mean();
}

struct HandSet::Target {
  std::array<std::array<float, 3>, kHandJoints> joints;
};

HandSet::HandSet(std::span<const HandJoints> hands)
    : size_(hands.size()), blocks_((hands.size() + kLanes - 1) / kLanes) {
  for (std::size_t i = 0; i < blocks_.size() * kLanes; ++i) {
    const Shape shape = shape_of(hands[std::min(i, size_ - 1)]);  // the last one fills its block
    for (int k = 0; k < kHandJoints; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        blocks_[i / kLanes].joints[k][axis][static_cast<Eigen::Index>(i % kLanes)] =
            static_cast<float>(shape.joints(axis, k));
      }
    }
  }
}

/// The best rotation is the quaternion that belongs to the largest eigenvalue of Horn's 4 x 4 matrix
/// ("Closed-form solution of absolute orientation using unit quaternions", 1987). Newton's method finds the
/// eigenvalue from above, and a column of the adjoint of what is left is the eigenvector (Theobald, "Rapid
/// calculation of RMSDs using a quaternion-based characteristic polynomial", 2005). As both shapes have size
/// 1, the eigenvalue is the best scale, too.
HandSet::Lanes HandSet::distances(const Block& block, const Target& target) {
  std::array<LanePoint, 3> s;  // sums of products: row by the hand's axis, column by the target's
  for (LanePoint& row : s) row.fill(Lanes::Zero());
  for (int k = 0; k < kHandJoints; ++k) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) s[a][b] += block.joints[k][a] * target.joints[k][b];
    }
  }
  const Lanes k01 = s[1][2] - s[2][1];
  const Lanes k02 = s[2][0] - s[0][2];
  const Lanes k03 = s[0][1] - s[1][0];
  const Lanes k12 = s[0][1] + s[1][0];
  const Lanes k13 = s[2][0] + s[0][2];
  const Lanes k23 = s[1][2] + s[2][1];
  const Lanes k00 = s[0][0] + s[1][1] + s[2][2];
  const Lanes k11 = s[0][0] - s[1][1] - s[2][2];
  const Lanes k22 = -s[0][0] + s[1][1] - s[2][2];
  const Lanes k33 = -s[0][0] - s[1][1] + s[2][2];

  // The characteristic polynomial x^4 + c2 x^2 + c1 x + c0: the matrix has no trace.
  Lanes squares = Lanes::Zero();
  for (const LanePoint& row : s) squares += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
  const Lanes c2 = -2.0f * squares;
  const Lanes c1 = -8.0f * (s[0][0] * (s[1][1] * s[2][2] - s[1][2] * s[2][1]) -
                            s[0][1] * (s[1][0] * s[2][2] - s[1][2] * s[2][0]) +
                            s[0][2] * (s[1][0] * s[2][1] - s[1][1] * s[2][0]));
  // Its last coefficient is the determinant, by 2 x 2 minors of the upper and the lower two rows.
  const auto determinant = [&](const Lanes& x) -> Lanes {
    const Lanes a = k00 - x;
    const Lanes b = k11 - x;
    const Lanes c = k22 - x;
    const Lanes d = k33 - x;
    return (a * b - k01 * k01) * (c * d - k23 * k23) - (a * k12 - k02 * k01) * (k12 * d - k23 * k13) +
           (a * k13 - k03 * k01) * (k12 * k23 - c * k13) + (k01 * k12 - k02 * b) * (k02 * d - k23 * k03) -
           (k01 * k13 - k03 * b) * (k02 * k23 - c * k03) + (k02 * k13 - k03 * k12) * (k02 * k13 - k12 * k03);
  };
  const Lanes c0 = determinant(Lanes::Zero());
  constexpr int kNewtonSteps = 8;
  Lanes x = Lanes::Ones();  // no eigenvalue is larger
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Lanes x2 = x * x;
    const Lanes b = (x2 + c2) * x;
    const Lanes a = b + c1;
    x -= (a * x + c0) / (2.0f * x2 * x + b + a).max(1e-12f);
  }

  // First column of the adjoint of (matrix - x).
  const Lanes b = k11 - x;
  const Lanes c = k22 - x;
  const Lanes d = k33 - x;
  const Lanes cd = c * d - k23 * k23;
  const Lanes b3 = k12 * d - k23 * k13;
  const Lanes b2 = k12 * k23 - c * k13;
  Lanes q0 = b * cd - k12 * b3 + k13 * b2;
  Lanes q1 = -(k01 * cd - k12 * (k02 * d - k23 * k03) + k13 * (k02 * k23 - c * k03));
  Lanes q2 = k01 * b3 - b * (k02 * d - k23 * k03) + k13 * (k02 * k13 - k12 * k03);
  Lanes q3 = -(k01 * b2 - b * (k02 * k23 - c * k03) + k12 * (k02 * k13 - k12 * k03));
  const Lanes norm = (q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3).max(1e-30f);
  const Lanes scale = x / norm;

  // Scaled rotation, hand to target.
  const std::array<LanePoint, 3> turn = {
      LanePoint{scale * (q0 * q0 + q1 * q1 - q2 * q2 - q3 * q3), scale * 2.0f * (q1 * q2 - q0 * q3),
                scale * 2.0f * (q1 * q3 + q0 * q2)},
      LanePoint{scale * 2.0f * (q1 * q2 + q0 * q3), scale * (q0 * q0 - q1 * q1 + q2 * q2 - q3 * q3),
                scale * 2.0f * (q2 * q3 - q0 * q1)},
      LanePoint{scale * 2.0f * (q1 * q3 - q0 * q2), scale * 2.0f * (q2 * q3 + q0 * q1),
                scale * (q0 * q0 - q1 * q1 - q2 * q2 + q3 * q3)}};
  Lanes sum = Lanes::Zero();
  for (int k = 0; k < kHandJoints; ++k) {
    Lanes square = Lanes::Zero();
    for (int a = 0; a < 3; ++a) {
      const Lanes difference = turn[a][0] * block.joints[k][0] + turn[a][1] * block.joints[k][1] +
                               turn[a][2] * block.joints[k][2] - target.joints[k][a];
      square += difference * difference;
    }
    sum += square.sqrt();
  }
  return sum / static_cast<float>(kHandJoints);
}

NearestHand HandSet::nearest(const HandJoints& target) const {
  const Shape shape = shape_of(target);
  Target single;
  for (int k = 0; k < kHandJoints; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      single.joints[k][axis] = static_cast<float>(shape.joints(axis, k));
    }
  }
  NearestHand nearest{std::numeric_limits<double>::infinity(), -1};
  for (std::size_t block = 0; block < blocks_.size(); ++block) {
    const Lanes mean = distances(blocks_[block], single);
    for (int lane = 0; lane < kLanes; ++lane) {
      const double distance = shape.size_mm * mean[lane];
      const auto index = static_cast<std::int64_t>(block) * kLanes + lane;
      if (distance < nearest.distance_mm && index < static_cast<std::int64_t>(size_)) {
        nearest = {distance, index};
      }
    }
  }
  return nearest;
}

}  // namespace knuckle
