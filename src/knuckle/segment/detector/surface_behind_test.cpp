// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/surface_behind.h"

#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

using testing::blank_frame;
using testing::draw_ball;
using testing::draw_rod;
using testing::put_depth;
using testing::quarter_vga_camera;

const Point3 kCentre(20, -10, 500);
constexpr double kRadiusMm = 90.0;

/// Draws the plane of the points p with normal.dot(p) = offset.
void draw_plane(
    Frame& frame, const Point3& normal, double offset_mm,
    const std::function<bool(int, int)>& is_seen = [](int, int) { return true; }, double noise_mm = 0.0) {
  const RayTable rays(frame.camera);
  const bool is_parallel = frame.camera.model == CameraModel::orthographic;
  Random random(7);
  for (int row = 0; row < frame.depth_mm.height(); ++row) {
    for (int column = 0; column < frame.depth_mm.width(); ++column) {
      const double x = rays.rays_x()(column, row);
      const double y = rays.rays_y()(column, row);
      const double depth = is_parallel ? (offset_mm - normal.x() * x - normal.y() * y) / normal.z()
                                       : offset_mm / normal.dot(Point3(x, y, 1));
      const double noisy = depth + noise_mm * random.normal();
      if (depth > 0 && is_seen(column, row)) put_depth(frame, column, row, noisy);
    }
  }
}

std::optional<SurfaceBehind> surface_of(const Frame& frame) {
  return surface_behind(frame.depth_mm, RayTable(frame.camera), kCentre, kRadiusMm);
}

Point3 slanted() {
  return Point3(0.2, -0.5, -0.8).normalized();
}

class SurfaceBehindTest : public ::testing::Test {
 protected:
  /// A plane 60 mm behind the centre, whichever way it is slanted.
  void draw_table(const Point3& normal, double noise_mm = 0.0) {
    draw_plane(
        frame_, normal, normal.dot(kCentre) - 60.0, [](int, int) { return true; }, noise_mm);
  }

  Frame frame_ = blank_frame(quarter_vga_camera());
};

TEST_F(SurfaceBehindTest, APlaneIsFoundWhicheverWayItIsSlanted) {
  for (const Point3& normal : {Point3(0, 0, -1), slanted(), Point3(-0.6, 0.1, -0.7).normalized().eval()}) {
    frame_ = blank_frame(quarter_vga_camera());
    draw_table(normal);
    draw_ball(frame_, kCentre, 40);
    const auto surface = surface_of(frame_);
    ASSERT_TRUE(surface);
    EXPECT_NEAR(surface->normal.cast<double>().dot(normal), 1.0, 1e-6) << "towards the camera";
    EXPECT_NEAR(surface->height_mm(kCentre.cast<float>()), 60.0, 0.05);
    EXPECT_LT(surface->deviation_mm, 0.01);
    EXPECT_FLOAT_EQ(surface->thickness_mm(), 6.0f);
  }
}

TEST_F(SurfaceBehindTest, AnOrthographicCameraSeesItTheSame) {
  Camera camera = quarter_vga_camera();
  camera.model = CameraModel::orthographic;
  camera.fx = camera.fy = 0.5;
  frame_ = blank_frame(camera);
  draw_table(slanted());
  const auto surface = surface_of(frame_);
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->normal.cast<double>().dot(slanted()), 1.0, 1e-6);
  EXPECT_NEAR(surface->height_mm(kCentre.cast<float>()), 60.0, 0.05);
}

TEST_F(SurfaceBehindTest, AnOrthographicCameraIsBeforeASurfaceThatGoesOnBehindItsOrigin) {
  Camera camera = quarter_vga_camera();
  camera.model = CameraModel::orthographic;
  camera.fx = camera.fy = 0.5;
  camera.cx = 0.0;
  frame_ = blank_frame(camera);
  const Point3 centre(400, 0, 150);
  const Point3 normal = Point3(0.6, 0, -0.8);  // where x is 0 the surface lies 75 mm behind the origin
  draw_plane(frame_, normal, normal.dot(centre) - 60.0);
  const auto surface = surface_behind(frame_.depth_mm, RayTable(camera), centre, kRadiusMm);
  ASSERT_TRUE(surface);
  EXPECT_NEAR(surface->normal.cast<double>().dot(normal), 1.0, 1e-6);
}

TEST_F(SurfaceBehindTest, NoiseAndThingsOnATableDoNotMoveIt) {
  draw_table(slanted(), 2.0);
  draw_ball(frame_, kCentre, 40);
  draw_rod(frame_, RayTable(frame_.camera), kCentre, kCentre + Point3(0, 300, 20), 30);  // the forearm
  const auto surface = surface_of(frame_);
  ASSERT_TRUE(surface);
  EXPECT_GT(surface->normal.cast<double>().dot(slanted()), std::cos(0.01));
  EXPECT_NEAR(surface->height_mm(kCentre.cast<float>()), 60.0, 1.0);
  // Depths err by 2 mm, across the plane by 0.83 of that, its slant's cosine; what of the arm comes near to
  // the table adds to it.
  EXPECT_GT(surface->deviation_mm, 1.5);
  EXPECT_LT(surface->deviation_mm, 2.4);
  EXPECT_FLOAT_EQ(surface->thickness_mm(), std::max(6.0f, 3 * surface->deviation_mm));
}

TEST_F(SurfaceBehindTest, NoiseMakesItThickerButNotThickerThanAFinger) {
  EXPECT_FLOAT_EQ((SurfaceBehind{.deviation_mm = 3.0f}.thickness_mm()), 9.0f);
  EXPECT_FLOAT_EQ((SurfaceBehind{.deviation_mm = 30.0f}.thickness_mm()), 15.0f);
}

TEST_F(SurfaceBehindTest, AForearmIsNone) {
  draw_ball(frame_, kCentre, 40);
  draw_rod(frame_, RayTable(frame_.camera), kCentre, kCentre + Point3(0, 300, 20), 30);
  EXPECT_FALSE(surface_of(frame_));
  // Nor is a board that ends in the hand: flat, but on one side.
  frame_ = blank_frame(quarter_vga_camera());
  draw_plane(frame_, Point3(0, 0, -1), -500.0,
             [](int column, int row) { return row > 120 && std::abs(column - 170) < 30; });
  EXPECT_FALSE(surface_of(frame_));
}

TEST_F(SurfaceBehindTest, ATableThatEndsBesideTheHandIsOne) {
  draw_plane(frame_, slanted(), slanted().dot(kCentre) - 60.0, [](int column, int) { return column < 175; });
  EXPECT_TRUE(surface_of(frame_));
}

TEST_F(SurfaceBehindTest, SurfacesOfWhichNoneIsMostAreNone) {
  // Four steps of a stair, 30 mm each: each has a quarter of what lies around.
  for (int step = 0; step < 4; ++step) {
    draw_plane(frame_, Point3(0, 0, -1), -(500.0 + 30.0 * step),
               [&](int column, int) { return (column / 4) % 4 == step; });
  }
  EXPECT_FALSE(surface_of(frame_));
}

TEST_F(SurfaceBehindTest, NothingMeasuredAroundIsNone) {
  EXPECT_FALSE(surface_of(frame_));
  draw_ball(frame_, kCentre, 40);
  EXPECT_FALSE(surface_of(frame_)) << "what the ball holds is not asked";
}

TEST_F(SurfaceBehindTest, PointsOnALineAreNoPlane) {
  for (int column = 0; column < 320; ++column) put_depth(frame_, column, 115, 500.0);
  EXPECT_FALSE(surface_of(frame_));
}

}  // namespace
}  // namespace knuckle
