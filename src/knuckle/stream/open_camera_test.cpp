// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/open_camera.h"

#include <algorithm>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

std::string fault_of(const std::string& text) {
  return error_of([&] { open_camera(text, UnknownIntrinsics::guess); });
}

bool is_built(std::string_view name) {
  const auto kinds = camera_kinds();
  const auto kind = std::ranges::find(kinds, name, &CameraKind::name);
  return kind != kinds.end() && kind->is_built;
}

TEST(OpenCamera, WhatNamesNoCameraIsRefused) {
  EXPECT_THAT(fault_of("webcam:0"), HasSubstr("unknown kind of camera 'webcam'"));
  EXPECT_THAT(fault_of("v4l2:"), HasSubstr("v4l2:: names no device"));
}

TEST(OpenCamera, WhatIsForRecordingsIsRefused) {
  for (const std::string option : {"first=3", "count=2", "step=2"}) {
    EXPECT_THAT(fault_of("v4l2:/dev/none?" + option), HasSubstr("first, count and step are for recordings"))
        << option;
  }
}

TEST(OpenCamera, AKinectHasASmallNumber) {
  if (!is_built("freenect")) {
    EXPECT_THAT(fault_of("freenect:0"), HasSubstr("lacks the library for such cameras"));
    return;
  }
  EXPECT_THAT(fault_of("freenect:-1"), HasSubstr("freenect:-1: -1 is no number of a Kinect"));
  EXPECT_THAT(fault_of("freenect:64"), HasSubstr("freenect:64: 64 is no number of a Kinect"));
}

}  // namespace
}  // namespace knuckle
