// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/camera_messages.h"

#include <cstring>
#include <limits>

#include <unistd.h>

#include "knuckle/core/limits.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

PipedDescription small() {
  PipedDescription description;
  description.width = 4;
  description.height = 3;
  return description;
}

std::string fault_of(const PipedDescription& description) {
  return error_of([&] { parse_description(bytes_of(description), "a.oni"); });
}

TEST(CameraMessages, ADescriptionComesThroughWhole) {
  PipedDescription description = small();
  description.frames = 17;
  description.unit_mm = 0.1;
  set_device(description, "Xtion");
  const PipedDescription parsed = parse_description(bytes_of(description), "a.oni");
  EXPECT_EQ(parsed.frames, 17);
  EXPECT_EQ(parsed.unit_mm, 0.1);
  EXPECT_STREQ(parsed.device, "Xtion");
}

TEST(CameraMessages, WhatCannotBeIsRefused) {
  const auto with = [](auto change) {
    PipedDescription description = small();
    change(description);
    return fault_of(description);
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(with([](auto& d) { d.width = 0; }), HasSubstr("a.oni: cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.width = 16385; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.height = 0; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.height = 16385; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.width = d.height = 16384; }), HasSubstr("cannot be depth"))
      << "more than a message holds";
  EXPECT_THAT(with([](auto& d) { d.unit_mm = 0.0; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.unit_mm = 1001.0; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.rate_hz = -1.0; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.rate_hz = kNan; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.unit_mm = kNan; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.horizontal_fov_rad = 4.0; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.vertical_fov_rad = kNan; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.frames = -2; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.frames = std::int64_t{1} << 62; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.depth = static_cast<PipedDepth>(3); }), HasSubstr("cannot be depth"));
  EXPECT_THAT(with([](auto& d) { d.is_mirrored = 2; }), HasSubstr("cannot be depth"));
  EXPECT_THAT(error_of([] { parse_description(bytes_of(small()).first(20), "a.oni"); }),
              HasSubstr("not whole"));
}

TEST(CameraMessages, ADescriptionsNameEndsInIt) {
  PipedDescription description = small();
  std::memset(description.device, 'x', sizeof description.device);
  EXPECT_EQ(std::strlen(parse_description(bytes_of(description), "a.oni").device), 127U);
}

TEST(CameraMessages, AFrameHasAllItsPixels) {
  std::vector<std::uint8_t> bytes(sizeof(PipedFrame) + 24);
  const PipedFrame frame{5, 0.25};
  std::memcpy(bytes.data(), &frame, sizeof frame);
  EXPECT_EQ(parse_piped_frame(bytes, small(), "a.oni").number, 5);
  bytes.push_back(0);
  EXPECT_THAT(error_of([&] { parse_piped_frame(bytes, small(), "a.oni"); }),
              HasSubstr("a frame is not whole"));
  bytes.resize(sizeof(PipedFrame) + 24);
  const PipedFrame timeless{5, std::numeric_limits<double>::infinity()};
  std::memcpy(bytes.data(), &timeless, sizeof timeless);
  EXPECT_THAT(error_of([&] { parse_piped_frame(bytes, small(), "a.oni"); }), HasSubstr("has the time"));
}

TEST(CameraMessages, AHeadThatIsNoneIsRefused) {
  const CameraMessageHead good{kCameraMessageMagic, 2, 100};
  EXPECT_NO_THROW(check(good, "a.oni"));
  for (const CameraMessageHead& head :
       {CameraMessageHead{1, 2, 100}, CameraMessageHead{kCameraMessageMagic, 0, 100},
        CameraMessageHead{kCameraMessageMagic, 6, 100},
        CameraMessageHead{kCameraMessageMagic, 2, limits::kCameraMessageBytes + 1}}) {
    EXPECT_THAT(error_of([&] { check(head, "a.oni"); }), HasSubstr("is no message"));
  }
}

TEST(CameraMessages, ATextIsCutOff) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_TRUE(put_text(ends[1], CameraMessage::fault, std::string(5000, 'a')));
  CameraMessageHead head;
  ASSERT_EQ(::read(ends[0], &head, sizeof head), static_cast<ssize_t>(sizeof head));
  EXPECT_EQ(head.bytes, kMostMessageText);
  ::close(ends[0]);
  ::close(ends[1]);
}

}  // namespace
}  // namespace knuckle
