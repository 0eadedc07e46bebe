// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/cube_patch.h"

#include <cmath>
#include <limits>

#include "knuckle/camera/projection.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/patch/patch_extractor.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

constexpr Cube kCube{96, 250.0};

/// A wall at one depth, seen by a camera of 320 x 240.
Frame wall(float depth_mm) {
  Frame frame;
  frame.name = "wall";
  frame.camera = {.width = 320, .height = 240, .fx = 224, .fy = 224, .cx = 159.5, .cy = 119.5};
  frame.depth_mm = Image<float>(320, 240, depth_mm);
  return frame;
}

TEST(CubePatch, MapsJointsToTheCubeAndBack) {
  const Frame frame = wall(500);
  const Projection projection(frame.camera);
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const Point3 centre(random.uniform(-200, 200), random.uniform(-150, 150), random.uniform(200, 1200));
    const PatchGeometry geometry = cube_geometry(frame.camera, projection.to_image(centre), kCube);
    const Point3 joint =
        centre + Point3(random.uniform(-120, 120), random.uniform(-120, 120), random.uniform(-120, 120));
    const ImagePoint in_image = projection.to_image(joint);
    const ImagePoint back = geometry.to_image(geometry.to_patch(in_image));
    EXPECT_NEAR(back.u, in_image.u, 1e-4);
    EXPECT_NEAR(back.v, in_image.v, 1e-4);
    EXPECT_NEAR((projection.to_camera(back) - joint).norm(), 0.0, 1e-4);
  }
}

TEST(CubePatch, ShowsTheCubesFacesAtItsCentresDepth) {
  // At 500 mm a millimetre covers 224 / 500 pixels; the cube's faces lie half a side beside the centre, half
  // a patch pixel beyond the centres of the outer pixels.
  const Frame frame = wall(500);
  const ImagePoint centre{100, 90, 500};
  const PatchGeometry geometry = cube_geometry(frame.camera, centre, kCube);
  const double face = geometry.to_patch({100 + 125 * 224.0 / 500, 90, 500}).u;
  EXPECT_NEAR(face * 0.5 * 95, 48.0, 1e-9);
  EXPECT_NEAR(geometry.to_patch({100, 90, 375}).d, -1.0, 1e-12);
  EXPECT_NEAR(geometry.to_patch({100, 90, 625}).d, 1.0, 1e-12);
}

TEST(CubePatch, AHandLooksTheSameAtAnyDistance) {
  // A ball of 50 mm radius around the cube's centre covers the same part of the patch near and far.
  for (const double distance : {350.0, 500.0, 800.0}) {
    Frame frame = wall(0);
    frame.camera = {.width = 640, .height = 480, .fx = 475, .fy = 475, .cx = 320, .cy = 240};
    frame.depth_mm = Image<float>(640, 480);
    const double radius_px = 50.0 * 475 / distance;
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        if (std::hypot(u - 320, v - 240) < radius_px) frame.depth_mm(u, v) = static_cast<float>(distance);
      }
    }
    const auto patch = extract_cube(frame, {320, 240, distance}, kCube);
    ASSERT_TRUE(patch);
    int inside = 0;
    for (const float d : patch->pixels.pixels()) inside += d == 0.0f ? 1 : 0;
    const double expected = M_PI * 50 * 50 / (250.0 * 250.0) * 96 * 96;
    EXPECT_NEAR(inside, expected, 0.05 * expected) << distance;
  }
}

TEST(CubePatch, DepthsBeyondTheCubeHolesAndTheBorderAreBackground) {
  Frame frame = wall(500);
  frame.depth_mm(100, 90) = 0;    // a hole
  frame.depth_mm(101, 90) = 376;  // just inside
  frame.depth_mm(102, 90) = 374;  // too near
  frame.depth_mm(103, 90) = 626;  // too far
  frame.depth_mm(104, 90) = std::numeric_limits<float>::quiet_NaN();
  frame.depth_mm(105, 90) = std::numeric_limits<float>::infinity();
  // A patch of the image's own pixels.
  const Cube cube{11, 11 * 500 / 224.0 * 1.0};
  const auto small = extract_cube(frame, {100, 90, 500}, cube);
  ASSERT_TRUE(small);
  EXPECT_EQ(small->pixels(5, 5), kCubeBackground);
  const auto large = extract_cube(frame, {100, 90, 500}, {112, 250});
  ASSERT_TRUE(large);
  const PatchGeometry& geometry = large->geometry;
  EXPECT_NEAR(geometry.image_px_per_patch_px, 1.0, 1e-12);
  // Patch column i is image column 100 + i - 55.5, rounded up.
  const int row = 55;
  EXPECT_EQ(large->pixels(55, row), kCubeBackground);
  EXPECT_NEAR(large->pixels(56, row), -124.0 / 125.0, 1e-6);
  for (const int column : {57, 58, 59, 60}) EXPECT_EQ(large->pixels(column, row), kCubeBackground) << column;
  EXPECT_EQ(large->pixels(61, row), 0.0f);
  // Half of the cube lies to the left of the image.
  const auto cut = extract_cube(frame, {0, 120, 500}, {112, 250});
  ASSERT_TRUE(cut);
  EXPECT_EQ(cut->pixels(54, 56), kCubeBackground);
  EXPECT_EQ(cut->pixels(56, 56), 0.0f);
}

TEST(CubePatch, NothingInTheCubeIsNoPatch) {
  EXPECT_FALSE(extract_cube(wall(900), {160, 120, 500}, kCube));
  EXPECT_FALSE(extract_cube(wall(500), {5000, 120, 500}, kCube));
  EXPECT_FALSE(extract_cube(wall(500), {160, 120, -500}, kCube));
  EXPECT_FALSE(extract_cube(wall(500), ImagePoint{}, kCube));
  EXPECT_THAT(error_of([] { extract_cube(wall(500), {160, 120, 500}, {1, 250}); }), HasSubstr("1 px"));
  for (const double side_mm : {0.0, -250.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(error_of([&] {
                  extract_cube(wall(500), {160, 120, 500}, {96, side_mm});
                }),
                HasSubstr("a side above 0"));
  }
}

TEST(CubePatch, TheExtractorsModeChoosesIt) {
  const Frame frame = wall(500);
  HandRegion hand;
  hand.box = {10, 10, 20, 20};
  hand.mask = Image<std::uint8_t>(20, 20, 1);
  hand.centre = Point3(30, -20, 480);
  const PatchExtractor extractor({.size_px = 48, .mode = "cube", .cube_mm = 200});
  const auto patch = extractor.extract(frame, hand);
  ASSERT_TRUE(patch);
  EXPECT_EQ(patch->pixels.width(), 48);
  EXPECT_NEAR(patch->geometry.mean_depth_mm, 480, 1e-9);
  EXPECT_NEAR(patch->pixels(24, 24), 0.2, 1e-6);
  const PatchExtractor fitted(PatchOptions{});
  EXPECT_THAT(error_of([&] { fitted.extract_around(frame, {160, 120, 500}); }), HasSubstr("cube"));
  EXPECT_THAT(error_of([] { PatchExtractor({.size_px = 48, .mode = "ball"}); }), HasSubstr("mode"));
}

}  // namespace
}  // namespace knuckle
