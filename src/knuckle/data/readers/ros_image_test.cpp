// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros_image.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

TEST(RosImage, OfAnotherEncodingIsRefused) {
  const RosImage colour{.width = 1, .height = 1, .encoding = "rgb8", .step = 3, .pixels = {}};
  EXPECT_THAT(error_of([&] { depth_mm_of(colour, 1.0, "here"); }),
              HasSubstr("here: has images of encoding 'rgb8', expected depth"));
  EXPECT_THAT(error_of([&] { infrared_of(colour, "here"); }),
              HasSubstr("here: has images of encoding 'rgb8', expected infrared"));
}

}  // namespace
}  // namespace knuckle
