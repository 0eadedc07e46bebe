// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/panels.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

Frame small_frame() {
  Frame frame;
  frame.camera = {.width = 40, .height = 30, .fx = 30, .fy = 30};
  frame.depth_mm = Image<float>(40, 30, 500.0f);
  return frame;
}

int brightness(const Rgb& colour) {
  return colour.red + colour.green + colour.blue;
}

TEST(Panels, WithoutMaskShowTheWholeFrame) {
  const Image<Rgb> picture = panels_of(small_frame(), 60);
  EXPECT_EQ(picture.width(), 80);
  EXPECT_EQ(picture.height(), 60);
}

TEST(Panels, ShowTheHandsSurroundingsThreeTimes) {
  Frame frame = small_frame();
  frame.mask = Image<std::uint8_t>(40, 30);
  frame.infrared = Image<std::uint16_t>(40, 30, 100);
  for (int row = 10; row < 18; ++row) {
    for (int column = 12; column < 20; ++column) {
      frame.mask(column, row) = 1;
      frame.infrared(column, row) = 900;
    }
  }
  const Image<Rgb> picture = panels_of(frame, 32);
  EXPECT_EQ(picture.height(), 32);
  EXPECT_EQ(picture.width(), 3 * 32 + 2 * 6);  // 16 x 16 pixels, enlarged twice, with gaps
  for (const int left : {38, 76}) {            // mask and infrared: bright in the middle
    EXPECT_GT(brightness(picture(left + 16, 16)), brightness(picture(left + 2, 2)) + 200);
  }
}

TEST(Panels, RefuseNoHeight) {
  EXPECT_THAT(testing::error_of([] { panels_of(small_frame(), 0); }), ::testing::HasSubstr("height"));
}

}  // namespace
}  // namespace knuckle
