// SPDX-License-Identifier: Apache-2.0
#include "knuckle/refine/surface_near.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr Camera kWallCamera{.width = 160, .height = 120, .fx = 150, .fy = 140, .cx = 85, .cy = 55};

/// A wall 500 mm before the camera, nowhere nearer than the landmarks before it, with a hole.
Frame wall() {
  Frame frame;
  frame.camera = kWallCamera;
  frame.depth_mm = Image<float>(kWallCamera.width, kWallCamera.height);
  for (int row = 0; row < kWallCamera.height; ++row)
    for (int column = 0; column < kWallCamera.width; ++column)
      frame.depth_mm(column, row) = 500.0f + 0.1f * static_cast<float>(column);
  frame.depth_mm(80, 60) = 0.0f;
  return frame;
}

/// Two landmarks before the wall, far from one another: one at the left edge, one in the middle; no others.
LandmarkTargets two_targets() {
  LandmarkTargets targets;
  const Projection projection(kWallCamera);
  targets[3].point = projection.to_camera({4.0, 30.0, 495.0});
  targets[7].point = projection.to_camera({80.0, 60.0, 497.0});
  return targets;
}

/// Every measured pixel within 40 mm of a landmark, in the order of the image.
std::vector<Point3> all_near(const Frame& frame, const LandmarkTargets& targets) {
  std::vector<Point3> points;
  for (int row = 0; row < kWallCamera.height; ++row) {
    for (int column = 0; column < kWallCamera.width; ++column) {
      const double depth = frame.depth_mm(column, row);
      if (!(depth > 0.0)) continue;
      const Point3 point =
          Projection(kWallCamera).to_camera({static_cast<double>(column), static_cast<double>(row), depth});
      if (std::ranges::any_of(targets,
                              [&](const auto& target) { return (target.point - point).norm() < 40.0; }))
        points.push_back(point);
    }
  }
  return points;
}

TEST(SurfaceNear, HasEveryPointThatIsNearALandmarkWhereThereIsRoom) {
  const Frame frame = wall();
  const std::vector<Point3> expected = all_near(frame, two_targets());
  const HandSurface surface = surface_near(frame, two_targets(), 1000000);
  ASSERT_GT(expected.size(), 500u);
  ASSERT_EQ(surface.points.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_LT((surface.points[i] - expected[i]).norm(), 1e-9) << i;
}

TEST(SurfaceNear, HasAboutAsManyPointsAsAskedEvenlySpread) {
  const Frame frame = wall();
  const std::vector<Point3> all = all_near(frame, two_targets());
  for (const int most : {25, 60, 150}) {
    const HandSurface surface = surface_near(frame, two_targets(), most);
    EXPECT_GT(surface.points.size(), static_cast<std::size_t>(0.6 * most)) << most;
    EXPECT_LT(surface.points.size(), static_cast<std::size_t>(1.6 * most)) << most;
    const double step_mm = 500.0 / 140.0 * std::sqrt(static_cast<double>(all.size()) / most);
    for (const Point3& point : all) {
      const bool has_neighbour = std::ranges::any_of(
          surface.points, [&](const Point3& chosen) { return (chosen - point).norm() < 2.0 * step_mm; });
      EXPECT_TRUE(has_neighbour) << most << ": " << point.transpose();
    }
  }
}

TEST(SurfaceNear, HasNothingWhereNoLandmarkIsKnownOrNoneIsSeen) {
  EXPECT_TRUE(surface_near(wall(), LandmarkTargets{}).points.empty());
  LandmarkTargets behind;
  behind[0].point = Point3(0.0, 0.0, -500.0);
  EXPECT_TRUE(surface_near(wall(), behind).points.empty());
  LandmarkTargets beside;
  beside[0].point = Point3(5000.0, 0.0, 500.0);
  EXPECT_TRUE(surface_near(wall(), beside).points.empty());
}

TEST(SurfaceNear, TellsTheDepthMeasuredWhereAPointIsSeen) {
  Frame frame = wall();
  frame.depth_mm(30, 20) = 0.0f;
  frame.depth_mm(31, 20) = 777.0f;
  frame.depth_mm(32, 20) = -3.0f;
  frame.depth_mm(33, 20) = static_cast<float>(kNaN);
  const HandSurface surface = surface_near(frame, {});
  const auto depth_at = [&](double u, double v) {
    return surface.depth_mm(Projection(kWallCamera).to_camera({u, v, 432.0}));
  };
  EXPECT_EQ(depth_at(30.4, 19.6), 0.0);
  EXPECT_EQ(depth_at(31.4, 20.4), 777.0);
  EXPECT_EQ(depth_at(32.0, 20.0), 0.0) << "no depth is negative";
  EXPECT_EQ(depth_at(33.0, 20.0), 0.0) << "nor NaN";
  EXPECT_EQ(depth_at(-2.0, 20.0), 0.0) << "outside of the image";
  EXPECT_EQ(depth_at(20.0, 1e9), 0.0);
  EXPECT_EQ(surface.depth_mm(Point3(0.0, 0.0, -5.0)), 0.0) << "behind the camera";
}

}  // namespace
}  // namespace knuckle
