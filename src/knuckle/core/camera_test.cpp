// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/camera.h"

#include "knuckle/core/frame.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

Camera example_camera() {
  Camera camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 224.0;
  camera.cx = 160.0;
  camera.cy = 120.0;
  return camera;
}

TEST(CameraTest, AFileThatCountsFromTheCornerHasItsPrincipalPointHalfAPixelLower) {
  const Camera corner = example_camera();
  const Camera centre = with_pixel_origin(corner, PixelOrigin::corner, PixelOrigin::centre);
  EXPECT_EQ(centre.cx, 159.5);
  EXPECT_EQ(centre.cy, 119.5);
  EXPECT_EQ(with_pixel_origin(centre, PixelOrigin::centre, PixelOrigin::corner), corner);
  EXPECT_EQ(with_pixel_origin(corner, PixelOrigin::corner, PixelOrigin::corner), corner);
}

TEST(CameraTest, ImpossibleValuesAreNamed) {
  const auto fault = [](auto change) {
    Camera camera = example_camera();
    change(camera);
    return error_of([&] { check(camera); });
  };
  EXPECT_NO_THROW(check(example_camera()));
  EXPECT_THAT(fault([](Camera& c) { c.width = 0; }), HasSubstr("width is 0"));
  EXPECT_THAT(fault([](Camera& c) { c.height = -1; }), HasSubstr("height is -1"));
  EXPECT_THAT(fault([](Camera& c) { c.fx = 0.0; }), HasSubstr("fx is 0"));
  EXPECT_THAT(fault([](Camera& c) { c.fy = kNaN; }), HasSubstr("fy is nan"));
  EXPECT_THAT(fault([](Camera& c) { c.cx = kNaN; }), HasSubstr("cx is nan"));
  EXPECT_THAT(fault([](Camera& c) { c.distortion[2] = kNaN; }), HasSubstr("distortion"));
  EXPECT_THAT(fault([](Camera& c) {
                c.model = CameraModel::orthographic;
                c.distortion[0] = 0.1;
              }),
              HasSubstr("orthographic"));
}

TEST(CameraTest, AMirroredFrameMirrorsBackToItself) {
  Frame frame;
  frame.camera = example_camera();
  frame.camera.distortion = {0.1, 0.2, 0.01, 0.02, 0, 0, 0, 0};
  frame.depth_mm = Image<float>(320, 240);
  frame.depth_mm(3, 5) = 400.0f;
  frame.truth = HandPose::missing(superset_convention());
  frame.truth->joints[0] = {3.0, 5.0, 400.0};
  const Frame mirror = mirrored(frame);
  EXPECT_EQ(mirror.depth_mm(316, 5), 400.0f);
  EXPECT_EQ(mirror.truth->joints[0].u, 316.0);
  EXPECT_EQ(mirrored(mirror).camera, frame.camera);
  EXPECT_EQ(mirrored(mirror).depth_mm, frame.depth_mm);
}

}  // namespace
}  // namespace knuckle
