// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/v4l2_format.h"

#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/named_table.h"

namespace knuckle {
namespace {

const V4l2DepthFormat& format_named(std::string_view name) {
  return *row_named(v4l2_depth_formats(), name);
}

TEST(V4l2Format, TheKernelsLettersNameTheFormats) {
  EXPECT_EQ(four_letters(format_named("z16").code), "Z16");
  EXPECT_EQ(four_letters(format_named("inzi").code), "INZI");
  EXPECT_EQ(four_letters(format_named("y16").code), "Y16");
}

// What RealSense D4xx (Z16: 1 mm) and SR300 (INZI: 1/8 mm) deliver.
TEST(V4l2Format, CountsAreWorthWhatTheirFormatSays) {
  EXPECT_EQ(format_named("z16").depth_unit_mm, 1.0);
  EXPECT_EQ(format_named("inzi").depth_unit_mm, 0.125);
  EXPECT_EQ(format_named("y16").depth_unit_mm, 1.0);
}

TEST(V4l2Format, DepthIsLittleEndianInItsUnit) {
  const std::vector<std::uint8_t> bytes{0x01, 0x00, 0x00, 0x02, 0, 0, 0xFF, 0xFF};
  const V4l2Images images = decode_v4l2(bytes, {format_named("z16"), 2, 2, 4}, 0.25);
  EXPECT_EQ(images.depth_mm(0, 0), 0.25f);
  EXPECT_EQ(images.depth_mm(1, 0), 128.0f);
  EXPECT_EQ(images.depth_mm(0, 1), 0.0f);
  EXPECT_EQ(images.depth_mm(1, 1), 0.25f * 65535);
  EXPECT_TRUE(images.infrared.empty());
}

TEST(V4l2Format, RowsMayBePadded) {
  const std::vector<std::uint8_t> bytes{1, 0, 2, 0, 9, 9, 3, 0, 4, 0, 9, 9};
  const V4l2Images images = decode_v4l2(bytes, {format_named("y16"), 2, 2, 6}, 1.0);
  EXPECT_EQ(images.depth_mm(1, 0), 2.0f);
  EXPECT_EQ(images.depth_mm(0, 1), 3.0f);
}

TEST(V4l2Format, InziIsInfraredAndThenDepth) {
  const std::vector<std::uint8_t> bytes{0xFF, 0x03, 7, 0, 8, 0, 0x10, 0x27};
  const V4l2Layout layout{format_named("inzi"), 2, 1, 4};
  EXPECT_EQ(layout.frame_bytes(), bytes.size());
  const V4l2Images images = decode_v4l2(bytes, layout, 0.125);
  EXPECT_EQ(images.infrared(0, 0), 1023);
  EXPECT_EQ(images.infrared(1, 0), 7);
  EXPECT_EQ(images.depth_mm(0, 0), 1.0f);
  EXPECT_EQ(images.depth_mm(1, 0), 1250.0f);
}

}  // namespace
}  // namespace knuckle
