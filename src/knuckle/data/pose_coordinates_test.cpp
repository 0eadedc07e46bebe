// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/pose_coordinates.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using ::testing::HasSubstr;

Projection example_projection() {
  return Projection({.width = 640, .height = 480, .fx = 500.0, .fy = 400.0, .cx = 320.0, .cy = 240.0});
}

TEST(PoseCoordinatesTest, AxesSayWhereEachNumberPoints) {
  Eigen::Matrix3d expected;
  expected << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  EXPECT_EQ(axes_from_text("x,-y,-z"), expected);
  // The first number points away from the camera, the second to the left, the third up.
  expected << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  EXPECT_EQ(axes_from_text(" z, -x ,-y"), expected);
  EXPECT_EQ(axes_from_text("x,y,z"), Eigen::Matrix3d::Identity());
  for (const char* text : {"", "x,y", "x,y,y", "x,y,w", "x,y,--z", "x,y,z,x", "xy,z,x", "x,,z"})
    EXPECT_THAT(error_of([&] { axes_from_text(text); }), HasSubstr("axes '" + std::string(text) + "'"));
}

TEST(PoseCoordinatesTest, UnitsAndFormatsAreKnownByName) {
  EXPECT_EQ(unit_from_text("mm"), 1.0);
  EXPECT_EQ(unit_from_text("cm"), 10.0);
  EXPECT_EQ(unit_from_text("m"), 1000.0);
  EXPECT_EQ(coordinate_kind_from_text("u v d"), PoseCoordinates::Kind::uvd);
  EXPECT_EQ(coordinate_kind_from_text("xyz"), PoseCoordinates::Kind::xyz);
  EXPECT_THAT(error_of([] { unit_from_text("inch"); }), HasSubstr("'inch'"));
  EXPECT_THAT(error_of([] { coordinate_kind_from_text("xy"); }), HasSubstr("known are uvd, xyz"));
}

TEST(PoseCoordinatesTest, APointIsFoundInAnyAxesAndUnit) {
  const Projection projection = example_projection();
  // 100 mm right, 50 mm down, 500 mm away: 100 and 40 px from the principal point.
  const PoseCoordinates usual{PoseCoordinates::Kind::xyz};
  ImagePoint point = image_point({100, 50, 500}, usual, &projection);
  EXPECT_NEAR(point.u, 420.0, 1e-9);
  EXPECT_NEAR(point.v, 280.0, 1e-9);
  EXPECT_NEAR(point.depth_mm, 500.0, 1e-9);
  const PoseCoordinates foreign{PoseCoordinates::Kind::xyz, axes_from_text("-z,x,-y"), 1000.0};
  point = image_point({-0.5, 0.1, -0.05}, foreign, &projection);
  EXPECT_NEAR(point.u, 420.0, 1e-9);
  EXPECT_NEAR(point.v, 280.0, 1e-9);
  EXPECT_NEAR(point.depth_mm, 500.0, 1e-9);
  const PoseCoordinates in_metres{PoseCoordinates::Kind::uvd, Eigen::Matrix3d::Identity(), 1000.0};
  point = image_point({420, 280, 0.5}, in_metres, nullptr);
  EXPECT_EQ(point.u, 420.0);
  EXPECT_EQ(point.depth_mm, 500.0);
}

TEST(PoseCoordinatesTest, WhatIsNotKnownOrBehindTheCameraIsMissing) {
  const Projection projection = example_projection();
  const PoseCoordinates xyz{PoseCoordinates::Kind::xyz};
  EXPECT_TRUE(image_point({kNaN, 1, 500}, xyz, &projection).is_missing());
  EXPECT_TRUE(image_point({10, 1, -500}, xyz, &projection).is_missing());
  EXPECT_TRUE(image_point({10, kNaN, 500}, {}, nullptr).is_missing());
}

TEST(PoseCoordinatesTest, AreToldAsTheOptionsThatSayThem) {
  EXPECT_EQ(as_options({}), "--format uvd");
  EXPECT_EQ(as_options({PoseCoordinates::Kind::xyz, axes_from_text("x,-y,-z"), 1000.0}),
            "--format xyz --axes x,-y,-z --unit m");
  EXPECT_EQ(as_options({PoseCoordinates::Kind::xyz, axes_from_text("-z,x,-y"), 10.0}),
            "--format xyz --axes -z,x,-y --unit cm");
}

}  // namespace
}  // namespace knuckle
