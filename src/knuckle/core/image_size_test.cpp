// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/image_size.h"

#include "knuckle/core/limits.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;

std::string fault_of_size(std::int64_t width, std::int64_t height) {
  return testing::error_of([&] { require_image_size({width, height}, "here"); });
}

TEST(ImageSize, OfACameraIsTaken) {
  require_image_size({1, 1}, "here");
  require_image_size({limits::kImageSide, limits::kImagePixels / limits::kImageSide}, "here");
  require_same_size({640, 480}, {640, 480}, "here");
}

TEST(ImageSize, ThatNoImageHasIsRefused) {
  EXPECT_THAT(fault_of_size(0, 1), HasSubstr("here: has 0 x 1 pixels, expected 1 to 16384 a side"));
  EXPECT_THAT(fault_of_size(1, -1), HasSubstr("expected 1 to 16384 a side"));
  EXPECT_THAT(fault_of_size(16385, 1), HasSubstr("expected 1 to 16384 a side"));
  EXPECT_THAT(fault_of_size(1, 16385), HasSubstr("expected 1 to 16384 a side"));
}

TEST(ImageSize, ThatWouldTakeAGigabyteIsRefused) {
  EXPECT_THAT(fault_of_size(16384, 16384),
              HasSubstr("here: has 16384 x 16384 pixels, expected at most 33554432 in all"));
  EXPECT_THAT(fault_of_size(16384, 2049), HasSubstr("expected at most 33554432 in all"));
}

TEST(ImageSize, OtherThanTheCamerasIsRefused) {
  EXPECT_EQ(testing::error_of([] {
              require_same_size({640, 480}, {640, 481}, "here");
            }),
            "here: is 640x480 pixels, expected 640x481");
}

}  // namespace
}  // namespace knuckle
