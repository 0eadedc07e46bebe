// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/pose_smoother.h"

#include <vector>

#include <Eigen/Geometry>

#include "knuckle/track/one_euro_filter.h"
#include "knuckle/track/rest_motion_filter.h"

namespace knuckle {
namespace {

/// A pose as the filters see it: the wrist's place, its turn, all angles.
constexpr int kTurn = 3;
constexpr int kAngles = 6;
constexpr int kSize = kAngles + kHandAngleCount;

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

/// Smooths a pose's numbers.
class PoseSmoother::Filter {
 public:
  virtual ~Filter() = default;
  virtual Eigen::VectorXd smooth(const Eigen::VectorXd& pose, double seconds) = 0;
  virtual void reset() = 0;
};

/// Place and turn have one speed each, every angle its own.
class PoseSmoother::OneEuro final : public Filter {
 public:
  explicit OneEuro(double strength) {
    const auto filter = [&](double cutoff_per_speed) {
      return OneEuroFilter(
          {.rest_cutoff_hz = 1.0 / strength, .cutoff_per_speed = cutoff_per_speed / strength});
    };
    parts_.push_back({0, kTurn, filter(0.06)});       // speeds in mm/s
    parts_.push_back({kTurn, kAngles, filter(6.0)});  // rad/s
    for (int i = kAngles; i < kSize; ++i) parts_.push_back({i, i + 1, filter(3.0)});
  }
  Eigen::VectorXd smooth(const Eigen::VectorXd& pose, double seconds) override {
    Eigen::VectorXd smoothed(kSize);
    for (Part& part : parts_) {
      const int count = part.end - part.begin;
      smoothed.segment(part.begin, count) = part.filter.smooth(pose.segment(part.begin, count), seconds);
    }
    return smoothed;
  }
  void reset() override {
    for (Part& part : parts_) part.filter.reset();
  }

 private:
  struct Part {
    int begin;
    int end;
    OneEuroFilter filter;
  };
  std::vector<Part> parts_;
};

/// The wrist rests or moves, and so do the digits, on their own.
class PoseSmoother::RestMotion final : public Filter {
 public:
  explicit RestMotion(double strength)
      : wrist_({}, strength * noise().head(kAngles)), digits_({}, strength * noise().tail(kHandAngleCount)) {}
  Eigen::VectorXd smooth(const Eigen::VectorXd& pose, double seconds) override {
    Eigen::VectorXd smoothed(kSize);
    smoothed << wrist_.smooth(pose.head(kAngles), seconds),
        digits_.smooth(pose.tail(kHandAngleCount), seconds);
    return smoothed;
  }
  void reset() override {
    wrist_.reset();
    digits_.reset();
  }

 private:
  /// Somewhat more than manifests/test_still.toml shows: a hand that moves has errors of its own.
  static Eigen::VectorXd noise() {
    constexpr double kPlaceNoiseMm = 1.2;
    constexpr double kTurnNoise = 0.018;  // [rad]
    constexpr double kAngleNoise = 0.05;  // [rad]
    Eigen::VectorXd noise(kSize);
    noise << Eigen::Vector3d::Constant(kPlaceNoiseMm), Eigen::Vector3d::Constant(kTurnNoise),
        Eigen::VectorXd::Constant(kHandAngleCount, kAngleNoise);
    return noise;
  }

  RestMotionFilter wrist_;
  RestMotionFilter digits_;
};

PoseSmoother::PoseSmoother(const TrackerOptions& options) {
  check_options(options, "tracker");
  if (options.smoothing == "one_euro") filter_ = std::make_unique<OneEuro>(options.strength);
  if (options.smoothing == "kalman") filter_ = std::make_unique<RestMotion>(options.strength);
}

PoseSmoother::~PoseSmoother() = default;
PoseSmoother::PoseSmoother(PoseSmoother&&) noexcept = default;
PoseSmoother& PoseSmoother::operator=(PoseSmoother&&) noexcept = default;

SkeletonPose PoseSmoother::smooth(const SkeletonPose& pose, double seconds) {
  if (!filter_) return pose;
  const Eigen::Matrix3d rotation = pose.camera_from_hand.linear();
  const bool is_first = !rotation_;
  if (is_first) rotation_ = rotation;
  // The filter works on rotation vectors from the last smoothed turn on, so it never meets the seam at half a
  // turn.
  Eigen::VectorXd numbers(kSize);
  numbers.head<3>() = pose.camera_from_hand.translation();
  numbers.segment<3>(kTurn) = turned_so_far_ + rotation_vector(rotation_->transpose() * rotation);
  for (int i = 0; i < kHandAngleCount; ++i) numbers[kAngles + i] = pose.angles.radians[i];

  const Eigen::VectorXd smoothed = filter_->smooth(numbers, seconds);
  SkeletonPose result = pose;
  if (is_first) return result;
  for (int i = 0; i < kHandAngleCount; ++i) result.angles.radians[i] = smoothed[kAngles + i];
  result.angles = clamped(result.angles);
  const Eigen::Vector3d part = smoothed.segment<3>(kTurn) - turned_so_far_;
  rotation_ = Eigen::Quaterniond(*rotation_ * rotation_of(part)).normalized().toRotationMatrix();
  turned_so_far_ += part;
  result.camera_from_hand.linear() = *rotation_;
  result.camera_from_hand.translation() = smoothed.head<3>();
  return result;
}

void PoseSmoother::reset() {
  if (filter_) filter_->reset();
  rotation_.reset();
  turned_so_far_.setZero();
}

}  // namespace knuckle
