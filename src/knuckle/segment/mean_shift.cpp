// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mean_shift.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace knuckle {
namespace {

using Lanes = Eigen::Array<float, PointCloud::kLanes, 1>;

// Points farther from the centre than this many bandwidths change it by less than 0.001 mm even where there
// are surfaces all around: beyond R a plane has the share (1 + R/h) exp(-R/h) = 7e-7 of the kernel's mass.
constexpr double kReach = 17.0;
// Points are gathered once for all centres within this many bandwidths of each other.
constexpr double kGatherMargin = 4.0;
// The first steps are those of eq. 2: they bring the centre onto the ridge of D (the middle of a finger, of
// the arm). Lengthened ones would leave for the other end of the ridge from beside it.
constexpr int kPlainSteps = 3;
constexpr double kLongestStep = 0.5;  // [bandwidths]
// Bounds how far a step is lengthened where D is flat or convex.
constexpr double kSmallestCurvature = 0.02;
// D in single precision is that uncertain: two centres within rounding of each other count as equal.
constexpr double kDensitySlack = 1e-5;
constexpr int kBlock = 512;               // points summed in single precision
constexpr float kSmallestRadius = 1e-6f;  // [mm] keeps 0 / 0 out of `spread` at a point of the cloud itself

Lanes lanes(const Eigen::ArrayXf& values, int first) {
  return values.segment<PointCloud::kLanes>(first);
}

/// One block's sums, kept apart by lane.
struct LaneSums {
  Lanes mass = Lanes::Zero();
  Lanes density = Lanes::Zero();
  Lanes x = Lanes::Zero(), y = Lanes::Zero(), z = Lanes::Zero();
  Lanes xx = Lanes::Zero(), xy = Lanes::Zero(), xz = Lanes::Zero();
  Lanes yy = Lanes::Zero(), yz = Lanes::Zero(), zz = Lanes::Zero();
};

LaneSums block_sums(const PointCloud& cloud, int first, int last, const Eigen::Array3f& centre,
                    float inverse_h) {
  LaneSums sums;
  for (int i = first; i < last; i += PointCloud::kLanes) {
    const Lanes dx = lanes(cloud.x, i) - centre.x();
    const Lanes dy = lanes(cloud.y, i) - centre.y();
    const Lanes dz = lanes(cloud.z, i) - centre.z();
    const Lanes r = (dx * dx + dy * dy + dz * dz).sqrt().max(kSmallestRadius);
    const Lanes r_over_h = r * inverse_h;
    const Lanes w = (-r_over_h).exp();
    sums.mass += w;
    sums.density += w * (r_over_h + 1.0f);
    sums.x += w * dx;
    sums.y += w * dy;
    sums.z += w * dz;
    const Lanes q = w / r;
    const Lanes qx = q * dx;
    const Lanes qy = q * dy;
    sums.xx += qx * dx;
    sums.xy += qx * dy;
    sums.xz += qx * dz;
    sums.yy += qy * dy;
    sums.yz += qy * dz;
    sums.zz += q * dz * dz;
  }
  return sums;
}

/// Newton's step towards the fixed point, or an ascending one where D is not concave; at most kLongestStep
/// long.
Eigen::Vector3d lengthened_step(const KernelSums& sums, double bandwidth_mm) {
  const Eigen::Vector3d step = sums.shift / sums.mass;
  const Eigen::Matrix3d curvature = Eigen::Matrix3d::Identity() - sums.spread / sums.mass;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(curvature);
  const Eigen::Array3d curvatures = solver.eigenvalues().array().abs().max(kSmallestCurvature);
  const Eigen::Vector3d along_axes = (solver.eigenvectors().transpose() * step).array() / curvatures;
  const Eigen::Vector3d lengthened = solver.eigenvectors() * along_axes;
  const double longest = kLongestStep * bandwidth_mm;
  return lengthened.norm() > longest ? Eigen::Vector3d(lengthened.normalized() * longest) : lengthened;
}

/// Kernel sums at one centre after another; gathers points again when the centre has gone too far.
class MovingWindow {
 public:
  MovingWindow(const PointsAround& points_around, double bandwidth_mm)
      : points_around_(points_around), bandwidth_mm_(bandwidth_mm) {}

  KernelSums sums_at(const Point3& centre) {
    ++evaluations_;
    if (!((centre - gathered_at_).norm() <= kGatherMargin * bandwidth_mm_)) {
      cloud_ = points_around_(centre, (kReach + kGatherMargin) * bandwidth_mm_);
      gathered_at_ = centre;
    }
    return kernel_sums(cloud_, centre, bandwidth_mm_);
  }
  int evaluations() const { return evaluations_; }
  PointCloud take_cloud() { return std::move(cloud_); }

 private:
  const PointsAround& points_around_;
  double bandwidth_mm_;
  Point3 gathered_at_ = Point3::Constant(kNaN);
  PointCloud cloud_;
  int evaluations_ = 0;
};

}  // namespace

void MeanShiftOptions::visit(OptionVisitor& visitor) {
  visitor.real("bandwidth_mm", bandwidth_mm, open_closed(0, 500));
  visitor.real("tolerance_mm", tolerance_mm, open_closed(0, 10));
  visitor.integer("max_iterations", max_iterations, closed(1, 10000));
}

KernelSums kernel_sums(const PointCloud& cloud, const Point3& centre, double bandwidth_mm) {
  KernelSums sums;
  const Eigen::Array3f middle = centre.cast<float>();
  const auto inverse_h = static_cast<float>(1.0 / bandwidth_mm);
  for (int first = 0; first < cloud.padded_size(); first += kBlock) {
    const int last = std::min(first + kBlock, cloud.padded_size());
    const LaneSums block = block_sums(cloud, first, last, middle, inverse_h);
    sums.mass += block.mass.sum();
    sums.density += block.density.sum();
    sums.shift += Eigen::Vector3d(block.x.sum(), block.y.sum(), block.z.sum());
    const double xy = block.xy.sum();
    const double xz = block.xz.sum();
    const double yz = block.yz.sum();
    Eigen::Matrix3d spread;
    spread << block.xx.sum(), xy, xz, xy, block.yy.sum(), yz, xz, yz, block.zz.sum();
    sums.spread += spread / bandwidth_mm;
  }
  return sums;
}

MeanShiftResult mean_shift(const PointsAround& points_around, const Point3& start,
                           const MeanShiftOptions& options) {
  const double h = options.bandwidth_mm;
  MovingWindow window(points_around, h);
  MeanShiftResult result;
  result.centre = start;
  KernelSums sums = window.sums_at(start);
  while (sums.mass > 0.0 && window.evaluations() < options.max_iterations) {
    const Eigen::Vector3d plain_step = sums.shift / sums.mass;
    const bool is_plain = window.evaluations() <= kPlainSteps;
    const Eigen::Vector3d step = is_plain ? plain_step : lengthened_step(sums, h);
    result.converged = !is_plain && step.norm() < options.tolerance_mm;
    if (result.converged) break;
    Point3 next = result.centre + step;
    KernelSums next_sums = window.sums_at(next);
    if (next_sums.density < sums.density * (1.0 - kDensitySlack)) {
      next = result.centre + plain_step;
      next_sums = window.sums_at(next);
    }
    result.centre = next;
    sums = next_sums;
  }
  result.mass = sums.mass;
  result.iterations = window.evaluations();
  result.cloud = window.take_cloud();
  return result;
}

}  // namespace knuckle
