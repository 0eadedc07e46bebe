// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/turned_patch.h"

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

}  // namespace
}  // namespace knuckle
