// SPDX-License-Identifier: Apache-2.0
// Training images on their way from worker to worker.
#include <algorithm>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/forest/pixel_samples.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr std::size_t kLengthsBytes = 24;            // width, height, tiles, pixels
constexpr std::size_t kTilesBytes = 2 * 4 * 4;       // 11 x 9 pixels: 2 x 2 squares and their border
constexpr std::size_t kPixelsBytes = 2 * 3 * 8 * 8;  // an empty square and two with measurements
constexpr std::size_t kScaleAt = kLengthsBytes + kTilesBytes + kPixelsBytes;

Camera small_camera() {
  Camera camera;
  camera.width = 11;
  camera.height = 9;
  camera.fx = 20.0;
  camera.fy = 30.0;
  return camera;
}

/// A message of one image with two pixels.
std::vector<std::byte> message_of_an_image() {
  Image<float> depth(11, 9, 0.0F);
  depth(1, 2) = 400.0F;
  depth(9, 3) = 500.0F;
  PixelSamples samples(1);
  samples.set(0, depth, small_camera(), std::vector<LabelledPixel>{{9, 3, 1}, {1, 2, 0}});
  const std::size_t bytes = samples.message_bytes(0);
  std::vector<std::byte> message;
  samples.take(0, message);
  EXPECT_EQ(message.size(), bytes);
  return message;
}

std::string fault_of(const std::vector<std::byte>& message) {
  return error_of([&] {
    PixelSamples samples(0);
    MessageReader reader(message);
    samples.put(reader);
  });
}

template <class T>
std::string fault_with(std::size_t at, T value) {
  std::vector<std::byte> message = message_of_an_image();
  std::memcpy(message.data() + at, &value, sizeof(value));
  return fault_of(message);
}

TEST(SampleMessages, AnImageArrivesAsItWas) {
  const std::vector<std::byte> message = message_of_an_image();
  PixelSamples samples(0);
  MessageReader reader(message);
  EXPECT_EQ(samples.put(reader), 0u);
  EXPECT_TRUE(reader.is_at_end());
  const PixelSamples::DepthImage& image = samples.images()[0];
  EXPECT_EQ(image.depth.width(), 11);
  EXPECT_EQ(image.depth.height(), 9);
  EXPECT_EQ(image.depth(1, 2), 400);
  EXPECT_EQ(image.depth(9, 3), 500);
  EXPECT_EQ(image.depth(2, 1), kFarDepth);
  EXPECT_EQ(image.scale.at(10).x, OffsetScale(small_camera()).at(10).x);
  EXPECT_EQ(image.scale.at(10).y, OffsetScale(small_camera()).at(10).y);
  ASSERT_EQ(image.pixels.size(), 2u);
  EXPECT_EQ(image.pixels[0].column, 1);
  EXPECT_EQ(image.pixels[0].row, 2);
  EXPECT_EQ(image.pixels[0].label, 0);
  EXPECT_EQ(image.pixels[1].label, 1);
}

TEST(SampleMessages, CutShortAnywhereAreRefused) {
  std::vector<std::byte> message = message_of_an_image();
  while (!message.empty()) {
    message.pop_back();
    EXPECT_THAT(fault_of(message), HasSubstr("a worker's message"));
  }
}

TEST(SampleMessages, NumbersThatNoImageHasAreRefused) {
  EXPECT_THAT(fault_with<std::int32_t>(0, 27), HasSubstr("sizes do not fit together"));
  EXPECT_THAT(fault_with<std::int32_t>(0, -1), HasSubstr("sizes do not fit together"));
  EXPECT_THAT(fault_with<std::int32_t>(0, std::numeric_limits<std::int32_t>::max()),
              HasSubstr("sizes do not fit together"));
  EXPECT_THAT(fault_with<std::uint64_t>(8, 15), HasSubstr("sizes do not fit together"));
  EXPECT_THAT(fault_with<std::uint64_t>(16, 0), HasSubstr("sizes do not fit together"));
  EXPECT_THAT(fault_with<std::uint64_t>(16, std::uint64_t{1} << 63U), HasSubstr("sizes do not fit together"));
  EXPECT_THAT(fault_with<std::uint16_t>(kLengthsBytes, 3), HasSubstr("has no tile 3"));
  EXPECT_THAT(fault_with<std::int16_t>(kLengthsBytes + kTilesBytes, 0), HasSubstr("a depth of 0 mm"));
  EXPECT_THAT(fault_with<std::int16_t>(kScaleAt - 2, kFarDepth + 1), HasSubstr("a depth of 10001 mm"));
  EXPECT_THAT(fault_with<std::uint8_t>(kScaleAt, 2), HasSubstr("no camera has the scale"));
  EXPECT_THAT(fault_with(kScaleAt + 1, std::numeric_limits<float>::quiet_NaN()),
              HasSubstr("no camera has the scale"));
  EXPECT_THAT(fault_with(kScaleAt + 5, -1.0F), HasSubstr("no camera has the scale"));
  EXPECT_THAT(fault_with<std::uint64_t>(kScaleAt + OffsetScale::kMessageBytes, std::uint64_t{1} << 40U),
              HasSubstr("ends early"));
  EXPECT_THAT(fault_with<std::int16_t>(kScaleAt + OffsetScale::kMessageBytes + 8, 11),
              HasSubstr("pixel (11, 2) of an image of 11 x 9"));
}

}  // namespace
}  // namespace knuckle
