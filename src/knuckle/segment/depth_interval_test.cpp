// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/depth_interval.h"

#include <limits>

#include <gmock/gmock.h>

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// 5 x 2 pixels, so neither a whole number of eights nor square.
Image<float> ramp() {
  Image<float> image(5, 2);
  for (std::size_t i = 0; i < image.size(); ++i) image.data()[i] = 100.0f * static_cast<float>(i);
  return image;
}

TEST(PixelsBetween, TakesBothBounds) {
  EXPECT_THAT(pixels_between(ramp(), 200.0, 600.0), ElementsAre(2, 3, 4, 5, 6));
  EXPECT_THAT(pixels_between(ramp(), 200.1, 599.9), ElementsAre(3, 4, 5));
  EXPECT_THAT(pixels_between(ramp(), 900.0, 900.0), ElementsAre(9));
}

TEST(PixelsBetween, LeavesOutWhatIsNotMeasured) {
  Image<float> image = ramp();
  image(1, 0) = kNan;
  image(2, 1) = kInfinity;
  image(3, 1) = -50.0f;
  EXPECT_THAT(pixels_between(image, -1e300, 1e300), ElementsAre(2, 3, 4, 5, 6, 9));
}

TEST(PixelsBetween, FindsNothingOutsideAndInNothing) {
  EXPECT_THAT(pixels_between(ramp(), 901.0, 1e9), IsEmpty());
  EXPECT_THAT(pixels_between(ramp(), 500.0, 400.0), IsEmpty());
  EXPECT_THAT(pixels_between(Image<float>(), 0.0, 1e9), IsEmpty());
}

}  // namespace
}  // namespace knuckle
