// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "knuckle/core/error.h"
#include "knuckle/hand/hand_rig.h"

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
struct HandShape {
  JointMatrix joints;
  double size_mm;
};

HandShape shape_of(const HandJoints& hand) {
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
    const HandShape shape = shape_of(hands[std::min(i, size_ - 1)]);  // the last one fills its block
    for (int k = 0; k < kHandJoints; ++k) {
      for (int axis = 0; axis < 3; ++axis) {
        blocks_[i / kLanes].joints[k][axis][static_cast<Eigen::Index>(i % kLanes)] =
            static_cast<float>(shape.joints(axis, k));
      }
    }
  }
}

namespace {

using Lanes = HandSet::Lanes;
using LanePoint = HandSet::LanePoint;
using LaneMatrix = std::array<LanePoint, 3>;

/// Sums of products of coordinates: row by the hand's axis, column by the target's.
template <class Block, class Target>
LaneMatrix sums_of_products(const Block& block, const Target& target) {
  LaneMatrix sums;
  for (LanePoint& row : sums) row.fill(Lanes::Zero());
  for (int k = 0; k < kHandJoints; ++k) {
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) sums[a][b] += block.joints[k][a] * target.joints[k][b];
    }
  }
  return sums;
}

Lanes determinant(const LaneMatrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
         m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

Lanes squared_norm(const LaneMatrix& m) {
  Lanes squares = Lanes::Zero();
  for (const LanePoint& row : m) squares += row[0] * row[0] + row[1] * row[1] + row[2] * row[2];
  return squares;
}

/// Horn's symmetric 4 x 4 matrix without trace, whose eigenvector of the largest eigenvalue is the quaternion
/// of the best rotation ("Closed-form solution of absolute orientation using unit quaternions", 1987).
struct HornMatrix {
  Lanes k00, k11, k22, k33, k01, k02, k03, k12, k13, k23;

  explicit HornMatrix(const LaneMatrix& s)
      : k00(s[0][0] + s[1][1] + s[2][2]),
        k11(s[0][0] - s[1][1] - s[2][2]),
        k22(-s[0][0] + s[1][1] - s[2][2]),
        k33(-s[0][0] - s[1][1] + s[2][2]),
        k01(s[1][2] - s[2][1]),
        k02(s[2][0] - s[0][2]),
        k03(s[0][1] - s[1][0]),
        k12(s[0][1] + s[1][0]),
        k13(s[2][0] + s[0][2]),
        k23(s[1][2] + s[2][1]) {}

  /// By 2 x 2 minors of the upper and the lower two rows.
  Lanes determinant() const {
    return (k00 * k11 - k01 * k01) * (k22 * k33 - k23 * k23) -
           (k00 * k12 - k02 * k01) * (k12 * k33 - k23 * k13) +
           (k00 * k13 - k03 * k01) * (k12 * k23 - k22 * k13) +
           (k01 * k12 - k02 * k11) * (k02 * k33 - k23 * k03) -
           (k01 * k13 - k03 * k11) * (k02 * k23 - k22 * k03) +
           (k02 * k13 - k03 * k12) * (k02 * k13 - k12 * k03);
  }

  /// An eigenvector, of any length: the first column of the adjoint of this matrix less `eigenvalue`
  /// (Theobald, "Rapid calculation of RMSDs using a quaternion-based characteristic polynomial", 2005).
  std::array<Lanes, 4> eigenvector(const Lanes& eigenvalue) const {
    const Lanes b = k11 - eigenvalue;
    const Lanes c = k22 - eigenvalue;
    const Lanes d = k33 - eigenvalue;
    const Lanes cd = c * d - k23 * k23;
    const Lanes b3 = k12 * d - k23 * k13;
    const Lanes b2 = k12 * k23 - c * k13;
    const Lanes a3 = k02 * d - k23 * k03;
    const Lanes a2 = k02 * k23 - c * k03;
    const Lanes a1 = k02 * k13 - k12 * k03;
    return {b * cd - k12 * b3 + k13 * b2, -(k01 * cd - k12 * a3 + k13 * a2), k01 * b3 - b * a3 + k13 * a1,
            -(k01 * b2 - b * a2 + k12 * a1)};
  }
};

/// The largest root of Horn's characteristic polynomial x^4 + c2 x^2 + c1 x + c0 by Newton's method from
/// above: of shapes of size 1, no eigenvalue is larger than 1.
Lanes largest_eigenvalue(const HornMatrix& matrix, const LaneMatrix& sums) {
  constexpr int kNewtonSteps = 8;
  const Lanes c2 = -2.0f * squared_norm(sums);
  const Lanes c1 = -8.0f * determinant(sums);
  const Lanes c0 = matrix.determinant();
  Lanes x = Lanes::Ones();
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Lanes x2 = x * x;
    const Lanes b = (x2 + c2) * x;
    const Lanes a = b + c1;
    x -= (a * x + c0) / (2.0f * x2 * x + b + a).max(1e-12f);
  }
  return x;
}

/// `scale` times the rotation of a quaternion of any length.
LaneMatrix scaled_rotation(const std::array<Lanes, 4>& q, const Lanes& scale) {
  const Lanes squares = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  const Lanes one = scale / squares.max(1e-30f);
  const Lanes two = 2.0f * one;
  return {LanePoint{one * (q[0] * q[0] + q[1] * q[1] - q[2] * q[2] - q[3] * q[3]),
                    two * (q[1] * q[2] - q[0] * q[3]), two * (q[1] * q[3] + q[0] * q[2])},
          LanePoint{two * (q[1] * q[2] + q[0] * q[3]),
                    one * (q[0] * q[0] - q[1] * q[1] + q[2] * q[2] - q[3] * q[3]),
                    two * (q[2] * q[3] - q[0] * q[1])},
          LanePoint{two * (q[1] * q[3] - q[0] * q[2]), two * (q[2] * q[3] + q[0] * q[1]),
                    one * (q[0] * q[0] - q[1] * q[1] - q[2] * q[2] + q[3] * q[3])}};
}

}  // namespace

/// As both shapes have size 1, the largest eigenvalue of Horn's matrix is the best scale, too.
HandSet::Lanes HandSet::distances(const Block& block, const Target& target) {
  const LaneMatrix sums = sums_of_products(block, target);
  const HornMatrix matrix(sums);
  const Lanes scale = largest_eigenvalue(matrix, sums);
  const LaneMatrix turn = scaled_rotation(matrix.eigenvector(scale), scale);
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
  const HandShape shape = shape_of(target);
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
