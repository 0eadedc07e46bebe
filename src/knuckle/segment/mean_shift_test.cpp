// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/mean_shift.h"

#include <cmath>

#include <gtest/gtest.h>

#include "knuckle/core/testing.h"
#include "knuckle/segment/nearest_pixel.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

struct Reference {
  Point3 centre;
  int iterations = 0;
};

/// Equation 2 as it stands: all points, double precision, plain steps until nothing moves.
Reference brute_force(const std::vector<Point3>& points, const Point3& start, double h) {
  Reference result{start};
  for (; result.iterations < 20000; ++result.iterations) {
    Point3 sum = Point3::Zero();
    double mass = 0.0;
    for (const Point3& point : points) {
      const double weight = std::exp(-(point - result.centre).norm() / h);
      sum += weight * point;
      mass += weight;
    }
    const Point3 next = sum / mass;
    const double step = (next - result.centre).norm();
    result.centre = next;
    if (step < 1e-6) break;
  }
  return result;
}

std::vector<Point3> points_of(const Frame& frame) {
  const Projection projection(frame.camera);
  std::vector<Point3> points;
  for (int row = 0; row < frame.camera.height; ++row) {
    for (int column = 0; column < frame.camera.width; ++column) {
      const double depth = frame.depth_mm(column, row);
      if (depth > 0) points.push_back(projection.to_camera(ImagePoint{double(column), double(row), depth}));
    }
  }
  return points;
}

std::vector<Point3> random_points(std::uint64_t seed, int count) {
  Random random(seed);
  std::vector<Point3> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(60 * random.normal(), 40 * random.normal(), 500 + 10 * random.normal());
  }
  return points;
}

PointsAround all_of(const std::vector<Point3>& points) {
  return [cloud = cloud_of(points)](const Point3&, double) { return cloud; };
}

TEST(KernelSums, AgreeWithDoublePrecision) {
  const std::vector<Point3> points = random_points(1, 3001);
  const Point3 centre(20, -10, 495);
  const double h = 13.5;
  KernelSums expected;
  for (const Point3& point : points) {
    const Point3 d = point - centre;
    const double w = std::exp(-d.norm() / h);
    expected.mass += w;
    expected.shift += w * d;
    expected.spread += w / (h * d.norm()) * d * d.transpose();
    expected.density += w * (d.norm() / h + 1);
  }
  const KernelSums sums = kernel_sums(cloud_of(points), centre, h);
  EXPECT_NEAR(sums.mass / expected.mass, 1.0, 2e-6);
  EXPECT_NEAR(sums.density / expected.density, 1.0, 2e-6);
  EXPECT_LT((sums.shift - expected.shift).norm(), 2e-6 * h * expected.mass);
  EXPECT_LT((sums.spread - expected.spread).norm(), 4e-6 * expected.mass);
}

TEST(KernelSums, OfOnePointAreItsKernelAtEveryDistance) {
  // Also checks the error of the vectorised exponential over the kernel's whole reach.
  const double h = 13.5;
  for (double distance = 0.0; distance < 21 * h; distance += 0.37) {
    const KernelSums sums = kernel_sums(cloud_of({Point3(100 + distance, 0, 512)}), Point3(100, 0, 512), h);
    const double rounded = double(float(100 + distance)) - 100.0;
    const double expected = std::exp(-rounded / h);
    EXPECT_NEAR(sums.mass / expected, 1.0, 4e-6) << distance;
    EXPECT_TRUE(sums.spread.allFinite());
  }
}

TEST(KernelSums, GradientOfTheDensityIsTheShiftOverTheSquaredBandwidth) {
  const PointCloud cloud = cloud_of(random_points(2, 4000));
  const double h = 40.0;
  const double step = 1.0;
  const Point3 centre(30, 15, 490);
  const KernelSums sums = kernel_sums(cloud, centre, h);
  for (int axis = 0; axis < 3; ++axis) {
    const Point3 offset = step * Point3::Unit(axis);
    const double difference =
        kernel_sums(cloud, centre + offset, h).density - kernel_sums(cloud, centre - offset, h).density;
    EXPECT_NEAR(difference / (2 * step), sums.shift[axis] / (h * h), 2e-3 * sums.mass / h) << axis;
  }
}

void expect_fixed_point_of_reference(const Frame& frame, const Point3& start) {
  const RayTable rays(frame.camera);
  const Reference expected = brute_force(points_of(frame), start, 13.5);
  const auto around = [&](const Point3& centre, double radius) {
    return points_around(frame.depth_mm, rays, centre, radius);
  };
  const MeanShiftResult result = mean_shift(around, start, {});
  EXPECT_TRUE(result.converged);
  EXPECT_LT((result.centre - expected.centre).norm(), 0.1)
      << result.iterations << " for " << expected.iterations << " iterations, from " << start.transpose();
  EXPECT_LT(result.iterations, expected.iterations);
}

TEST(MeanShift, FindsTheFixedPointOfTheBruteForceReferenceFromTheNearestPoint) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const Frame frame = testing::hand_frame(seed, 12000);
    const NearestPixel nearest = *nearest_pixel(frame.depth_mm);
    const ImagePoint pixel{double(nearest.column), double(nearest.row), nearest.depth_mm};
    expect_fixed_point_of_reference(frame, Projection(frame.camera).to_camera(pixel));
  }
}

TEST(MeanShift, StaysInTheBasinOfItsStart) {
  // In these two frames lengthened steps alone leave the basin of one of the starts.
  for (const std::uint64_t seed : {107u, 118u}) {
    const Frame frame = testing::hand_frame(seed, 20000);
    const Projection projection(frame.camera);
    Random random(seed);
    for (int i = 0; i < 10;) {
      const int column = static_cast<int>(random.below(320));
      const int row = static_cast<int>(random.below(200));
      const float depth = frame.depth_mm(column, row);
      if (!is_measured(depth) || depth > 750.0f) continue;
      expect_fixed_point_of_reference(frame, projection.to_camera({double(column), double(row), depth}));
      ++i;
    }
  }
}

TEST(MeanShift, EndsAsNewtonsMethodDoes) {
  // Near the end each step squares the error: a hundredth of the tolerance takes a step or two more, where
  // steps of half the length would take seven.
  const PointsAround cloud = all_of(random_points(4, 4000));
  const auto iterations = [&](double tolerance_mm) {
    const MeanShiftResult result =
        mean_shift(cloud, Point3(60, 20, 500), {.bandwidth_mm = 40.0, .tolerance_mm = tolerance_mm});
    EXPECT_TRUE(result.converged);
    return result.iterations;
  };
  EXPECT_LE(iterations(0.01), iterations(1.0) + 2);
}

TEST(MeanShift, StaysAtACloudOfOnePoint) {
  const Point3 point(10, 20, 400);
  const MeanShiftResult result = mean_shift(all_of({point}), Point3(13, 20, 404), {});
  EXPECT_TRUE(result.converged);
  EXPECT_LT((result.centre - point).norm(), 0.02);
  EXPECT_TRUE(mean_shift(all_of({point}), point, {}).converged);
}

TEST(MeanShift, SaysThatAnEmptyCloudHasNoMass) {
  const MeanShiftResult result = mean_shift(all_of({}), Point3(0, 0, 400), {});
  EXPECT_EQ(result.mass, 0.0);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.cloud.size(), 0);
}

TEST(MeanShift, EndsAfterTheGivenIterations) {
  MeanShiftOptions options;
  options.max_iterations = 3;
  const MeanShiftResult result = mean_shift(all_of(random_points(3, 2000)), Point3(150, 0, 500), options);
  EXPECT_FALSE(result.converged);
  EXPECT_LE(result.iterations, 4);
}

}  // namespace
}  // namespace knuckle
