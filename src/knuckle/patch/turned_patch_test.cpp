// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/turned_patch.h"

#include <cmath>

#include "knuckle/core/angle.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

Image<float> counted(int size) {
  Image<float> image(size, size);
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) image(u, v) = static_cast<float>(10 * v + u);
  }
  return image;
}

TEST(TurnedPatch, AQuarterTakesTheRightToTheBottom) {
  const Image<float> image = turned(counted(3), 1);
  EXPECT_EQ(image(1, 2), 12.0f) << "what was right of the middle";
  EXPECT_EQ(image(2, 0), 0.0f) << "what was the first pixel";
  EXPECT_EQ(image(1, 1), 11.0f);
  const Image<float> half = turned(counted(3), 2);
  EXPECT_EQ(half(2, 2), 0.0f);
  EXPECT_EQ(half(0, 1), 12.0f);
}

TEST(TurnedPatch, PointsGoWithTheirPixels) {
  constexpr int kSize = 5;
  const Image<float> image = counted(kSize);
  const auto pixel = [](double along) { return static_cast<int>((along + 1.0) / 2.0 * (kSize - 1) + 0.5); };
  for (int quarters = 0; quarters < 4; ++quarters) {
    const Image<float> other = turned(image, quarters);
    for (const PatchPoint& point :
         {PatchPoint{-1.0, 0.5, 0.3}, PatchPoint{0.0, -0.5, -1.0}, PatchPoint{1.0, 1.0, 0.0}}) {
      const PatchPoint there = turned(point, quarters);
      EXPECT_EQ(other(pixel(there.u), pixel(there.v)), image(pixel(point.u), pixel(point.v))) << quarters;
      EXPECT_EQ(there.d, point.d);
      const PatchPoint back = turned(there, 4 - quarters);
      EXPECT_EQ(back.u, point.u);
      EXPECT_EQ(back.v, point.v);
    }
  }
}

TEST(TurnedPatch, ByAnyAngleAsByQuarters) {
  for (int quarters = 0; quarters < 4; ++quarters) {
    for (const int size : {4, 5}) {
      const Image<float> expected = turned(counted(size), quarters);
      const Image<float> image = turned_by(counted(size), quarters * 90.0 * kDegree, -1.0f);
      for (int v = 0; v < size; ++v) {
        for (int u = 0; u < size; ++u) EXPECT_EQ(image(u, v), expected(u, v)) << quarters << ' ' << size;
      }
    }
    const PatchPoint expected = turned(PatchPoint{0.25, -0.5, 0.3}, quarters);
    const PatchPoint point = turned_by(PatchPoint{0.25, -0.5, 0.3}, quarters * 90.0 * kDegree);
    EXPECT_NEAR(point.u, expected.u, 1e-12);
    EXPECT_NEAR(point.v, expected.v, 1e-12);
    EXPECT_EQ(point.d, 0.3);
  }
}

TEST(TurnedPatch, ByAnyAngleEachPixelIsTheNearest) {
  constexpr int kSize = 21;
  constexpr double kMiddle = 10.0;
  const Image<float> image = [&] {  // each pixel says where it was
    Image<float> places(kSize, kSize);
    for (int v = 0; v < kSize; ++v) {
      for (int u = 0; u < kSize; ++u) places(u, v) = static_cast<float>(100 * v + u);
    }
    return places;
  }();
  for (const double degrees : {-67.0, -40.0, 13.0, 30.0}) {
    const Image<float> other = turned_by(image, degrees * kDegree, -1.0f);
    int inside = 0;
    for (int v = 0; v < kSize; ++v) {
      for (int u = 0; u < kSize; ++u) {
        if (other(u, v) < 0.0f) {
          EXPECT_GT(std::hypot(u - kMiddle, v - kMiddle), kMiddle) << "nothing is lost within the circle";
          continue;
        }
        const int from = static_cast<int>(other(u, v));
        const PatchPoint there =
            turned_by(PatchPoint{from % 100 - kMiddle, from / 100 - kMiddle, 0.0}, degrees * kDegree);
        EXPECT_LE(std::hypot(there.u - (u - kMiddle), there.v - (v - kMiddle)), std::sqrt(0.5) + 1e-9);
        ++inside;
      }
    }
    EXPECT_GT(inside, 300) << "of " << kSize * kSize;
  }
}

}  // namespace
}  // namespace knuckle
