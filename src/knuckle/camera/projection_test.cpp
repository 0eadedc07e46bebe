// SPDX-License-Identifier: Apache-2.0
#include "knuckle/camera/projection.h"

#include "knuckle/core/frame.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

Camera pinhole() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = 224.5;
  camera.fy = 230.25;
  camera.cx = 161.0;
  camera.cy = 118.0;
  return camera;
}

Camera distorted(std::array<double, 8> coefficients) {
  Camera camera = pinhole();
  camera.distortion = coefficients;
  return camera;
}

Camera orthographic() {
  Camera camera = pinhole();
  camera.model = CameraModel::orthographic;
  camera.fx = 0.8;
  camera.fy = 0.7;
  return camera;
}

Camera upward() {
  Camera camera = pinhole();
  camera.fy = -camera.fy;
  return camera;
}

struct NamedCamera {
  std::string name;
  Camera camera;
};

class EachCamera : public ::testing::TestWithParam<NamedCamera> {};

TEST_P(EachCamera, ProjectionAndItsInverseAgree) {
  const Projection projection(GetParam().camera);
  for (int v = 0; v < 240; v += 7) {
    for (int u = 0; u < 320; u += 7) {
      for (const double depth_mm : {150.0, 400.0, 4000.0}) {
        const ImagePoint point{u + 0.25, v - 0.5, depth_mm};
        const ImagePoint back = projection.to_image(projection.to_camera(point));
        ASSERT_NEAR(back.u, point.u, 1e-9 * 320) << u << " " << v;
        ASSERT_NEAR(back.v, point.v, 1e-9 * 240) << u << " " << v;
        ASSERT_EQ(back.depth_mm, depth_mm);
      }
    }
  }
}

TEST_P(EachCamera, RayTableAgreesWithTheProjection) {
  const Projection projection(GetParam().camera);
  const RayTable rays(GetParam().camera);
  for (const auto& [column, row] : {std::pair{0, 0}, {319, 0}, {160, 120}, {17, 239}}) {
    const Point3 point = projection.to_camera(ImagePoint{double(column), double(row), 500.0});
    EXPECT_NEAR(rays.x(column, row, 500.0f), point.x(), 1e-3);
    EXPECT_NEAR(rays.y(column, row, 500.0f), point.y(), 1e-3);
  }
}

TEST_P(EachCamera, TheMirroredCameraSeesTheMirroredPoint) {
  const Projection projection(GetParam().camera);
  const Projection mirror(mirrored(GetParam().camera));
  const Point3 point = projection.to_camera(ImagePoint{42.0, 99.0, 450.0});
  const ImagePoint seen = mirror.to_image(Point3(-point.x(), point.y(), point.z()));
  EXPECT_NEAR(seen.u, 319.0 - 42.0, 1e-9);
  EXPECT_NEAR(seen.v, 99.0, 1e-9);
}

TEST_P(EachCamera, AMissingPointStaysMissing) {
  const Projection projection(GetParam().camera);
  EXPECT_TRUE(projection.to_image(projection.to_camera(ImagePoint{})).is_missing());
}

INSTANTIATE_TEST_SUITE_P(
    All, EachCamera,
    ::testing::Values(NamedCamera{"pinhole", pinhole()}, NamedCamera{"orthographic", orthographic()},
                      NamedCamera{"upward", upward()},
                      NamedCamera{"barrel", distorted({-0.25, 0.08, 0, 0, 0, 0, 0, 0})},
                      NamedCamera{"tangential", distorted({0.1, -0.05, 2e-3, -3e-3, 0.01, 0, 0, 0})},
                      NamedCamera{"rational", distorted({0.3, 0.1, 1e-3, 5e-4, 0.02, 0.25, 0.12, 0.01})}),
    [](const auto& instance) { return instance.param.name; });

// The value was worked out by hand from the formula in OpenCV's documentation of its camera model.
TEST(ProjectionTest, DistortionFollowsOpenCvsFormula) {
  Camera camera = distorted({0.1, 0.01, 0.002, 0.003, 0.001, 0.05, 0.02, 0.004});
  camera.fx = camera.fy = 100.0;
  camera.cx = camera.cy = 0.0;
  const double x = 0.3, y = -0.4, r2 = 0.25;
  const double radial = (1 + 0.1 * r2 + 0.01 * r2 * r2 + 0.001 * r2 * r2 * r2) /
                        (1 + 0.05 * r2 + 0.02 * r2 * r2 + 0.004 * r2 * r2 * r2);
  const ImagePoint seen = Projection(camera).to_image(Point3(300.0, -400.0, 1000.0));
  EXPECT_NEAR(seen.u, 100.0 * (x * radial + 2 * 0.002 * x * y + 0.003 * (r2 + 2 * x * x)), 1e-10);
  EXPECT_NEAR(seen.v, 100.0 * (y * radial + 0.002 * (r2 + 2 * y * y) + 2 * 0.003 * x * y), 1e-10);
}

TEST(ProjectionTest, APointBehindTheCameraIsMissing) {
  EXPECT_TRUE(Projection(pinhole()).to_image(Point3(10.0, 10.0, -100.0)).is_missing());
  EXPECT_TRUE(Projection(pinhole()).to_image(Point3(10.0, 10.0, 0.0)).is_missing());
}

TEST(ProjectionTest, PixelsPerMillimetreIsTheSlopeOfTheProjection) {
  for (const Camera& camera : {pinhole(), orthographic()}) {
    const Projection projection(camera);
    const double slope =
        projection.to_image(Point3(1.0, 0.0, 500.0)).u - projection.to_image(Point3(0.0, 0.0, 500.0)).u;
    EXPECT_NEAR(projection.pixels_per_mm(500.0), slope, 1e-9);
  }
}

TEST(ProjectionTest, AnImpossibleCameraIsRefused) {
  EXPECT_THAT(testing::error_of([] { Projection{Camera{}}; }), ::testing::HasSubstr("width"));
}

}  // namespace
}  // namespace knuckle
