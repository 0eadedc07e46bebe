// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/surface_picture.h"

#include <algorithm>

#include "knuckle/camera/projection.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

constexpr Camera kProjective{.width = 64, .height = 48, .fx = 60.0, .fy = 62.0, .cx = 31.0, .cy = 24.5};
constexpr Camera kOrthographic{.model = CameraModel::orthographic,
                               .width = 64,
                               .height = 48,
                               .fx = 0.5,
                               .fy = 0.5,
                               .cx = 31.0,
                               .cy = 24.5};
constexpr Box kAll{0, 0, 64, 48};

/// A ball of flesh.
std::vector<FleshCone> ball(const Point3& centre, double radius) {
  return {{centre, radius, centre, radius}};
}

TEST(SeenSurface, EveryPixelSeesTheSkinOnItsRay) {
  const Point3 centre(12.0, -8.0, 400.0);
  constexpr double kRadius = 60.0;
  for (const Camera& camera : {kProjective, kOrthographic}) {
    const Projection projection(camera);
    const SeenSurface seen = seen_surface(ball(centre, kRadius), camera, {kAll, 1.0});
    int hits = 0;
    for (int row = 0; row < 48; ++row) {
      for (int column = 0; column < 64; ++column) {
        const double depth = seen.depth_mm(column, row);
        if (depth == 0.0) continue;
        ++hits;
        const Point3 skin = projection.to_camera({double(column), double(row), depth});
        EXPECT_NEAR((skin - centre).norm(), kRadius, 0.01);
        EXPECT_LT(skin.z(), centre.z()) << "the near side of the ball";
      }
    }
    const ImagePoint middle = projection.to_image(centre);
    const double radius_px = kRadius * projection.pixels_per_mm(centre.z());
    EXPECT_NEAR(hits, std::numbers::pi * radius_px * radius_px,
                0.15 * std::numbers::pi * radius_px * radius_px);
    EXPECT_NEAR(seen.facing(int(std::lround(middle.u)), int(std::lround(middle.v))), 1.0, 0.05);
  }
}

TEST(SeenSurface, AViewIsAPartOfTheImageAtAnotherScale) {
  const auto flesh = ball({0.0, 0.0, 400.0}, 60.0);
  const SeenSurface whole = seen_surface(flesh, kProjective, {kAll, 1.0});
  const SeenSurface part = seen_surface(flesh, kProjective, {{20, 15, 21, 17}, 3.0});
  ASSERT_EQ(part.depth_mm.width(), 63);
  for (int row = 0; row < 17; ++row) {
    for (int column = 0; column < 21; ++column) {
      // The middle of the nine picture pixels of a pixel.
      EXPECT_NEAR(part.depth_mm(3 * column + 1, 3 * row + 1), whole.depth_mm(20 + column, 15 + row), 1e-3);
    }
  }
}

TEST(SeenSurface, TheNearerOfTwoHidesTheOther) {
  std::vector<FleshCone> flesh = ball({0.0, 0.0, 600.0}, 50.0);
  const double far = seen_surface(flesh, kProjective, {kAll, 1.0}).depth_mm(31, 24);
  flesh.push_back(ball({0.0, 0.0, 400.0}, 10.0).front());
  const double near = seen_surface(flesh, kProjective, {kAll, 1.0}).depth_mm(31, 24);
  EXPECT_NEAR(far, 550.0, 1.0);
  EXPECT_NEAR(near, 390.0, 1.0);
  std::ranges::reverse(flesh);
  EXPECT_EQ(seen_surface(flesh, kProjective, {kAll, 1.0}).depth_mm(31, 24), near);
}

TEST(SurfaceDifference, TellsBeforeFromBehindAndWhatWasNotMeasured) {
  const auto flesh = ball({0.0, 0.0, 400.0}, 60.0);
  const View view{kAll, 1.0};
  Image<float> depth = seen_surface(flesh, kProjective, view).depth_mm;
  const auto picture_with = [&](float offset) {
    Image<float> moved = depth;
    for (float& value : moved.pixels()) value = value > 0.0f ? value + offset : 900.0f;
    return surface_difference(flesh, moved, kProjective, view, {300.0, 900.0});
  };
  const SurfaceDifference same = picture_with(0.0f);
  EXPECT_EQ(same.picture(31, 24), kAlike);
  EXPECT_EQ(same.median_mm, 0.0);
  EXPECT_EQ(picture_with(50.0f).picture(31, 24), kMeasuredBehind);
  EXPECT_EQ(picture_with(-50.0f).picture(31, 24), kMeasuredBefore);
  EXPECT_NEAR(picture_with(-7.0f).median_mm, 7.0, 1e-3);
  depth = Image<float>(64, 48);
  const SurfaceDifference nothing = surface_difference(flesh, depth, kProjective, view, {300.0, 900.0});
  EXPECT_EQ(nothing.picture(31, 24), kNotMeasured);
  EXPECT_TRUE(std::isnan(nothing.median_mm));
}

TEST(SurfaceDifference, ItsColoursPassFromOneEndToTheOther) {
  EXPECT_EQ(difference_colour(0.0), kAlike);
  EXPECT_EQ(difference_colour(kDifferenceMm), kMeasuredBehind);
  EXPECT_EQ(difference_colour(-1e9), kMeasuredBefore);
  EXPECT_EQ(difference_colour(-kDifferenceMm / 2.0), mixed(kAlike, kMeasuredBefore, 0.5));
}

TEST(SurfaceDifference, AViewMayReachOverTheImage) {
  const auto flesh = ball({0.0, 0.0, 400.0}, 200.0);
  const View view{{-20, -30, 100, 100}, 0.5};
  const Image<float> depth(64, 48, 200.0f);
  const SurfaceDifference difference = surface_difference(flesh, depth, kProjective, view, {100.0, 300.0});
  EXPECT_EQ(difference.picture.width(), 50);
  EXPECT_EQ(difference.picture(25, 12), kNotMeasured) << "above the image, where there is flesh";
}

TEST(SurfacePicture, ShadesWhatFacesTheCameraBrightestAndNothingElse) {
  const auto flesh = ball({0.0, 0.0, 400.0}, 60.0);
  const View view{kAll, 1.0};
  Image<Rgb> picture(64, 48, kSheetColour);
  draw_surface(picture, seen_surface(flesh, kProjective, view));
  EXPECT_EQ(picture(0, 0), kSheetColour);
  const auto sum = [&](int column) {
    const Rgb colour = picture(column, 24);
    return colour.red + colour.green + colour.blue;
  };
  EXPECT_GT(sum(31), sum(38));
  EXPECT_NE(picture(38, 24), kSheetColour);
}

}  // namespace
}  // namespace knuckle
