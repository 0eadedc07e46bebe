// SPDX-License-Identifier: Apache-2.0
// PNG files of OpenCV, and ours read by it. A program of its own: OpenCV's codecs load a hundred libraries.
#include <cstdint>
#include <vector>

#include <opencv2/imgcodecs.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/readers/png_decoder.h"
#include "knuckle/data/readers/png_encoder.h"

namespace knuckle {
namespace {

TEST(PngDecoder, DecodesWhatAnotherCoderWrote) {
  Random random(1);
  for (const int type : {CV_8UC1, CV_16UC1, CV_8UC3, CV_8UC4, CV_16UC3}) {
    for (const int filter : {8, 16, 32, 64, 128, 248}) {  // none, sub, up, average, Paeth, all
      cv::Mat image(7, 13, type);
      for (int row = 0; row < image.rows; ++row) {
        auto* const bytes = image.ptr<std::uint8_t>(row);
        for (std::size_t i = 0; i < image.cols * image.elemSize(); ++i) {
          bytes[i] = static_cast<std::uint8_t>(random() % 7 == 0 ? random() : 40 + i);
        }
      }
      std::vector<std::uint8_t> png;
      ASSERT_TRUE(cv::imencode(".png", image, png, {cv::IMWRITE_PNG_STRATEGY, filter % 5}));
      const PngPixels pixels = decode_png(png, "a.png");
      ASSERT_EQ(pixels.width, 13);
      ASSERT_EQ(pixels.height, 7);
      ASSERT_EQ(pixels.channels, image.channels());
      ASSERT_EQ(pixels.bits, static_cast<int>(8 * image.elemSize1()));
      for (int row = 0; row < image.rows; ++row) {
        for (int column = 0; column < image.cols; ++column) {
          for (int channel = 0; channel < image.channels(); ++channel) {
            const int other = channel < 3 && image.channels() >= 3 ? 2 - channel : channel;  // BGR
            const std::size_t size = image.elemSize1();
            const auto* const is =
                pixels.bytes.data() + ((row * 13 + column) * image.channels() + channel) * size;
            const auto* const expected = image.ptr<std::uint8_t>(row, column) + other * size;
            for (std::size_t byte = 0; byte < size; ++byte) ASSERT_EQ(is[byte], expected[byte]);
          }
        }
      }
    }
  }
}

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

}  // namespace
}  // namespace knuckle
