// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/hand_region.h"

#include "knuckle/core/testing.h"
#include "knuckle/segment/testing.h"

namespace knuckle {
namespace {

TEST(HandRegion, HasTheBoxAndMaskOfItsPixels) {
  const HandRegion region = region_of_pixels({2 * 10 + 3, 4 * 10 + 7, 3 * 10 + 5}, 10);
  EXPECT_EQ(region.box, (Box{3, 2, 5, 3}));
  ASSERT_EQ(region.mask.width(), 5);
  ASSERT_EQ(region.mask.height(), 3);
  int count = 0;
  for (const std::uint8_t pixel : region.mask.pixels()) count += pixel;
  EXPECT_EQ(count, 3);
  EXPECT_EQ(region.mask(0, 0), 1);
  EXPECT_EQ(region.mask(4, 2), 1);
  EXPECT_EQ(region.mask(2, 1), 1);
}

TEST(HandRegion, MirrorsBackToItself) {
  HandRegion region = region_of_pixels({2 * 10 + 3, 4 * 10 + 7, 3 * 10 + 5}, 10);
  region.centre = Point3(12, 3, 500);
  const HandRegion mirror = mirrored(region, 10);
  EXPECT_EQ(mirror.box, (Box{2, 2, 5, 3}));
  EXPECT_EQ(mirror.mask(4, 0), 1);
  EXPECT_EQ(mirror.centre, Point3(-12, 3, 500));
  const HandRegion back = mirrored(mirror, 10);
  EXPECT_EQ(back.box, region.box);
  EXPECT_EQ(back.mask, region.mask);
  EXPECT_EQ(back.centre, region.centre);
}

TEST(PixelArea, GrowsWithTheSquareOfTheDepthOfAProjectiveCamera) {
  Camera camera = testing::quarter_vga_camera();
  camera.fx = 200;
  camera.fy = -250;
  EXPECT_DOUBLE_EQ(pixel_area_mm2(camera, 1000.0), 20.0);
  camera.model = CameraModel::orthographic;
  camera.fx = 0.5;
  camera.fy = 0.25;
  EXPECT_DOUBLE_EQ(pixel_area_mm2(camera, 1000.0), 8.0);
}

}  // namespace
}  // namespace knuckle
