// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/pose_smoother.h"

#include <Eigen/Geometry>

namespace knuckle {
namespace {

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

}  // namespace

PoseSmoother::PoseSmoother(const PoseSmoothing& options)
    : place_(options.place), turn_(options.turn), angles_(kHandAngleCount, OneEuroFilter(options.angles)) {}

SkeletonPose PoseSmoother::smooth(const SkeletonPose& pose, double seconds) {
  SkeletonPose smoothed = pose;
  for (std::size_t i = 0; i < angles_.size(); ++i) {
    const Eigen::VectorXd angle = Eigen::VectorXd::Constant(1, pose.angles.radians[i]);
    smoothed.angles.radians[i] = angles_[i].smooth(angle, seconds)[0];
  }
  smoothed.camera_from_hand.translation() = place_.smooth(pose.camera_from_hand.translation(), seconds);
  const Eigen::Matrix3d rotation = pose.camera_from_hand.linear();
  // The filter works on rotation vectors from the last smoothed turn on, so it never meets the seam at half a
  // turn.
  if (!rotation_) {
    turn_.smooth(Eigen::Vector3d::Zero(), seconds);
    rotation_ = rotation;
  } else {
    const Eigen::Vector3d away = rotation_vector(rotation_->transpose() * rotation);
    const Eigen::Vector3d part = turn_.smooth(turned_so_far_ + away, seconds) - turned_so_far_;
    rotation_ = Eigen::Quaterniond(*rotation_ * rotation_of(part)).normalized().toRotationMatrix();
    turned_so_far_ += part;
  }
  smoothed.camera_from_hand.linear() = *rotation_;
  return smoothed;
}

void PoseSmoother::reset() {
  place_.reset();
  turn_.reset();
  for (OneEuroFilter& angle : angles_) angle.reset();
  rotation_.reset();
  turned_so_far_.setZero();
}

}  // namespace knuckle
