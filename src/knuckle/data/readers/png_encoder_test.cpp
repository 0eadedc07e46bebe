// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/png_encoder.h"

#include <opencv2/imgcodecs.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// What another reader finds in `png`; colours there are in the order blue, green, red.
template <class Pixel>
cv::Mat_<Pixel> read_by_another(const std::vector<std::uint8_t>& png) {
  const cv::Mat image = cv::imdecode(png, cv::IMREAD_UNCHANGED);
  EXPECT_EQ(image.type(), cv::traits::Type<Pixel>::value);
  return image;
}

/// Runs, slopes and noise, so that each of the coder's ways is taken.
template <class T>
Image<T> varied_image(int width, int height) {
  Random random(11);
  Image<T> image(width, height);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const std::uint64_t noise = random();
      image(column, row) = static_cast<T>(row % 3 == 0 ? noise : row % 3 == 1 ? 257 * column : 40'000 + row);
    }
  }
  return image;
}

template <class T>
void expect_read_by_another(const Image<T>& image) {
  const cv::Mat_<T> read = read_by_another<T>(encode_png(image));
  ASSERT_EQ(read.cols, image.width());
  ASSERT_EQ(read.rows, image.height());
  for (int row = 0; row < image.height(); ++row) {
    for (int column = 0; column < image.width(); ++column) {
      ASSERT_EQ(read(row, column), image(column, row)) << column << ", " << row;
    }
  }
}

TEST(PngEncoder, AnotherReaderFindsTheSameDepths) {
  expect_read_by_another(varied_image<std::uint16_t>(321, 243));
  expect_read_by_another(varied_image<std::uint16_t>(1, 5));
  expect_read_by_another(Image<std::uint16_t>(7, 1, 0x0102));
}

TEST(PngEncoder, AnotherReaderFindsTheSameMasks) {
  expect_read_by_another(varied_image<std::uint8_t>(33, 5));
  expect_read_by_another(Image<std::uint8_t>(640, 480, 0));
}

TEST(PngEncoder, AnotherReaderFindsTheSameColours) {
  Image<Rgb> image(2, 2);
  image(0, 0) = {255, 128, 0};
  image(1, 0) = {1, 2, 3};
  image(0, 1) = {4, 5, 6};
  const cv::Mat_<cv::Vec3b> read = read_by_another<cv::Vec3b>(encode_png(image));
  ASSERT_EQ(read.size(), cv::Size(2, 2));
  EXPECT_EQ(read(0, 0), cv::Vec3b(0, 128, 255));
  EXPECT_EQ(read(0, 1), cv::Vec3b(3, 2, 1));
  EXPECT_EQ(read(1, 0), cv::Vec3b(6, 5, 4));
  EXPECT_EQ(read(1, 1), cv::Vec3b(0, 0, 0));
}

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
