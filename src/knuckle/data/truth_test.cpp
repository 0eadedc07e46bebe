// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/truth.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr Landmark kThree[] = {Landmark::palm, Landmark::wrist, Landmark::thumb_tip};
constexpr Convention kConvention{"three3", kThree};

TEST(PoseFromUvd, AJointWithoutDepthIsNotKnown) {
  const std::vector<double> uvd{1, 2, 500, 3, 4, 0, 5, 6, -1};
  const HandPose pose = pose_from_uvd(kConvention, uvd);
  EXPECT_EQ(pose.joints[0].u, 1.0);
  EXPECT_EQ(pose.joints[0].v, 2.0);
  EXPECT_EQ(pose.joints[0].depth_mm, 500.0);
  EXPECT_TRUE(pose.joints[1].is_missing() && pose.joints[2].is_missing());
}

TEST(PoseFromUvd, AJointOfWhichANumberIsMissingIsNotKnown) {
  const HandPose pose =
      pose_from_uvd(kConvention, std::vector<double>{kNaN, 2, 500, 3, kNaN, 500, 5, 6, 700});
  EXPECT_TRUE(pose.joints[0].is_missing() && std::isnan(pose.joints[0].v));
  EXPECT_TRUE(pose.joints[1].is_missing() && std::isnan(pose.joints[1].u));
  EXPECT_EQ(pose.joints[2].depth_mm, 700.0);
}

TEST(PoseFromCamera, ProjectsWhatIsKnown) {
  Camera camera{.width = 80, .height = 60, .fx = 100.0, .fy = 50.0, .cx = 40.0, .cy = 20.0};
  const HandPose pose = pose_from_camera(
      kConvention, std::vector<double>{10, 20, 500, kNaN, 2, 3, 5, 6, -700}, Projection(camera));
  EXPECT_DOUBLE_EQ(pose.joints[0].u, 42.0);
  EXPECT_DOUBLE_EQ(pose.joints[0].v, 22.0);
  EXPECT_EQ(pose.joints[0].depth_mm, 500.0);
  EXPECT_TRUE(pose.joints[1].is_missing() && pose.joints[2].is_missing());
}

TEST(PointsInCamera, AreWhatAPoseWasMadeFrom) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = 60.0;
  camera.fy = 58.0;
  camera.cx = 30.0;
  camera.cy = 25.0;
  const Projection projection(camera);
  const Convention& convention = convention_from_name("icg20");
  std::vector<double> xyz(3 * convention.landmarks.size());
  for (std::size_t i = 0; i < xyz.size(); ++i) xyz[i] = 300.0 + 7.0 * static_cast<double>(i);
  xyz[3 * 4 + 1] = kNaN;
  const std::vector<Point3> points =
      points_in_camera(pose_from_camera(convention, xyz, projection), projection);
  ASSERT_EQ(points.size(), convention.landmarks.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 4) {
      EXPECT_TRUE(points[i].array().isNaN().all());
    } else {
      EXPECT_LT((points[i] - Point3(xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2])).norm(), 1e-9);
    }
  }
}

TEST(PoseOrigin, MovesBothCoordinatesByHalfAPixel) {
  HandPose pose = HandPose::missing(kConvention);
  pose.joints[1] = {10.0, 70.0, 500.0};
  const HandPose corner = with_pixel_origin(pose, PixelOrigin::centre, PixelOrigin::corner);
  EXPECT_EQ(corner.joints[1].u, 10.5);
  EXPECT_EQ(corner.joints[1].v, 70.5);
  EXPECT_EQ(corner.joints[1].depth_mm, 500.0);
  EXPECT_TRUE(corner.joints[0].is_missing());
  const HandPose back = with_pixel_origin(corner, PixelOrigin::corner, PixelOrigin::centre);
  EXPECT_EQ(back.joints[1].u, 10.0);
  EXPECT_EQ(back.joints[1].v, 70.0);
  EXPECT_EQ(with_pixel_origin(pose, PixelOrigin::corner, PixelOrigin::corner).joints[1].u, 10.0);
}

TEST(KnownOrNothing, APoseOfWhichNothingIsKnownIsNone) {
  HandPose pose = HandPose::missing(kConvention);
  EXPECT_FALSE(known_or_nothing(pose));
  pose.joints[2] = {1.0, 2.0, 3.0};
  EXPECT_TRUE(known_or_nothing(pose));
}

}  // namespace
}  // namespace knuckle
