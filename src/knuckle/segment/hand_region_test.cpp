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

TEST(HandRegion, AMirrorTurnsBoxMaskAndCentre) {
  HandRegion region = region_of_pixels({1 * 10 + 0, 1 * 10 + 1, 2 * 10 + 0, 4 * 10 + 3}, 10);
  region.centre = Point3(7.0, -3.0, 450.0);
  region.score = 0.25;
  const HandRegion mirror = mirrored(region, 10);
  EXPECT_EQ(mirror.box, (Box{6, 1, 4, 4}));
  EXPECT_THAT(mirror.mask.pixels(), ::testing::ElementsAre(0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0));
  EXPECT_EQ(mirror.centre, Point3(-7.0, -3.0, 450.0));
  EXPECT_EQ(mirror.score, 0.25);
}

TEST(RegionInCube, IsCutAtAllFourEndsOfTheImage) {
  Frame frame;
  frame.camera = {.width = 40, .height = 12, .fx = 50.0, .fy = 50.0, .cx = 20.0, .cy = 6.0};
  frame.depth_mm = Image<float>(40, 12, 500.0f);
  EXPECT_EQ(region_in_cube(frame, Point3(0.0, 0.0, 500.0), 1000.0).box, (Box{0, 0, 40, 12}));
  EXPECT_EQ(region_in_cube(frame, Point3(150.0, 40.0, 500.0), 100.0).box, (Box{30, 5, 10, 7}));
  EXPECT_EQ(region_in_cube(frame, Point3(-190.0, -50.0, 500.0), 100.0).box, (Box{0, 0, 6, 6}));
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

TEST(RegionInCube, HoldsWhatIsMeasuredInTheCube) {
  Frame frame;
  frame.camera = {.width = 40, .height = 30, .fx = 50.0, .fy = 50.0, .cx = 20.0, .cy = 10.0};
  frame.depth_mm = Image<float>(40, 30, 500.0f);
  frame.depth_mm(25, 12) = 551.0f;  // beyond the cube
  frame.depth_mm(26, 12) = 0.0f;
  frame.depth_mm(27, 12) = 449.0f;  // before it
  frame.depth_mm(28, 12) = 451.0f;
  // (5, 2) px off the middle; 100 mm are 10 px at 500 mm.
  const HandRegion region = region_in_cube(frame, Point3(50.0, 20.0, 500.0), 100.0);
  EXPECT_EQ(region.box, (Box{20, 7, 10, 10}));
  EXPECT_EQ(region.mask(5, 5), 0);
  EXPECT_EQ(region.mask(6, 5), 0);
  EXPECT_EQ(region.mask(7, 5), 0);
  EXPECT_EQ(region.mask(8, 5), 1);
  EXPECT_EQ(region.centre, Point3(50.0, 20.0, 500.0));
  EXPECT_TRUE(region_in_cube(frame, Point3(0.0, 0.0, 900.0), 100.0).mask.empty());
}

}  // namespace
}  // namespace knuckle
