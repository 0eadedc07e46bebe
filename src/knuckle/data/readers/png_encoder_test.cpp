// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/png_encoder.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

TEST(PngEncoder, AnEmptyFrameTakesHardlyAnyRoom) {
  EXPECT_LT(encode_png(Image<std::uint16_t>(640, 480)).size(), 6000u);  // 614,400 bytes of pixels
}

TEST(PngEncoder, ImagesThatNoPngHoldsAreRefused) {
  EXPECT_THAT(error_of([] { encode_png(Image<std::uint16_t>()); }),
              HasSubstr("an image of 0 x 0 pixels cannot be encoded as PNG: "));
  EXPECT_THAT(error_of([] { encode_png(Image<std::uint8_t>(1'000'001, 1)); }),
              HasSubstr("an image of 1000001 x 1 pixels cannot be encoded as PNG: "));
}

}  // namespace
}  // namespace knuckle
