// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/point_cloud.h"

#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/segment/ray_cache.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

void expect_points_within(const Frame& frame, const Point3& centre, double radius_mm) {
  const Projection projection(frame.camera);
  const PointCloud cloud = points_around(frame.depth_mm, RayTable(frame.camera), centre, radius_mm);
  int next = 0;
  for (int pixel = 0; pixel < static_cast<int>(frame.depth_mm.size()); ++pixel) {
    const float depth = frame.depth_mm.data()[pixel];
    if (!is_measured(depth)) continue;
    const int column = pixel % frame.camera.width;
    const int row = pixel / frame.camera.width;
    const Point3 point = projection.to_camera({double(column), double(row), depth});
    const double distance = (point - centre).norm();
    if (distance > radius_mm + 1e-3) continue;
    if (distance > radius_mm - 1e-3 && (next >= cloud.size() || cloud.pixels[next] != pixel)) continue;
    ASSERT_LT(next, cloud.size());
    ASSERT_EQ(cloud.pixels[next], pixel);
    EXPECT_LT((Point3(cloud.x[next], cloud.y[next], cloud.z[next]) - point).norm(), 1e-3);
    ++next;
  }
  EXPECT_EQ(next, cloud.size());
  EXPECT_EQ(cloud.padded_size() % PointCloud::kLanes, 0);
  for (int i = cloud.size(); i < cloud.padded_size(); ++i) EXPECT_GT(cloud.x[i], 1e8f);
}

TEST(PointCloud, HoldsThePointsOfTheBall) {
  Frame frame = testing::hand_frame(3);
  frame.depth_mm(5, 5) = std::numeric_limits<float>::quiet_NaN();
  frame.depth_mm(6, 5) = std::numeric_limits<float>::infinity();
  frame.depth_mm(7, 5) = -450.0f;
  for (const double radius : {30.0, 155.0, 284.0, 1e6})
    expect_points_within(frame, Point3(10, -20, 480), radius);
}

TEST(PointCloud, FollowsTheDistortionOfTheCamera) {
  Frame frame = testing::hand_frame(4);
  frame.camera.distortion = {-0.2, 0.05, 0.001, -0.002, 0, 0, 0, 0};
  expect_points_within(frame, Point3(10, -20, 480), 155.0);
}

TEST(PointCloud, OfAnOrthographicCameraHasParallelRays) {
  Frame frame = testing::hand_frame(5);
  frame.camera.model = CameraModel::orthographic;
  frame.camera.fx = 0.5;
  frame.camera.fy = -0.5;
  expect_points_within(frame, Point3(10, -20, 480), 155.0);
}

TEST(RayCache, KeepsTheLastCamera) {
  RayCache cache;
  Camera camera = testing::quarter_vga_camera();
  const auto first = cache.rays_of(camera);
  EXPECT_EQ(cache.rays_of(camera), first);
  camera.cx += 1;
  const auto second = cache.rays_of(camera);
  EXPECT_NE(second, first);
  EXPECT_EQ(second->camera(), camera);
  EXPECT_EQ(first->camera(), testing::quarter_vga_camera());
  camera.fx = 0;
  EXPECT_THROW((void)cache.rays_of(camera), Error);
}

TEST(PointsAround, LooksAtEachKthPixelWhereThereAreMoreThanAsked) {
  Image<float> depth(10, 7, 500.0f);
  depth(0, 0) = 900.0f;  // out of the interval: 69 pixels are left
  const Camera camera{.width = 10, .height = 7, .fx = 100.0, .fy = 100.0, .cx = 4.5, .cy = 3.0};
  const RayTable rays(camera);
  const PointCloud all = points_around(depth, rays, Point3(0, 0, 500), 100, 69);
  EXPECT_EQ(all.size(), 69);
  EXPECT_EQ(all.thinning, 1);
  const PointCloud few = points_around(depth, rays, Point3(0, 0, 500), 100, 20);
  EXPECT_EQ(few.thinning, 4);
  ASSERT_EQ(few.size(), 18);
  for (int i = 0; i < few.size(); ++i) EXPECT_EQ(few.pixels[i], all.pixels[4 * i]);
}

}  // namespace
}  // namespace knuckle
