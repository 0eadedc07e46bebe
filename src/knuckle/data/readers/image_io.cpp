// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/image_io.h"

#include <algorithm>
#include <fstream>
#include <string_view>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/image_cv.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

constexpr std::string_view kPngSignature = "\x89PNG\r\n\x1a\n";
constexpr std::string_view kPngEnd = std::string_view("IEND\xae\x42\x60\x82");

/// OpenCV fills what a file cut short lacks with zeros and does not say so: look for the end mark ourselves.
void require_whole_png(std::string_view bytes, const std::filesystem::path& path) {
  if (!bytes.starts_with(kPngSignature)) fail("{}: not a PNG image", path.string());
  if (bytes.find(kPngEnd) == std::string_view::npos) fail("{}: the PNG image is cut short", path.string());
}

cv::Mat read_png(const std::filesystem::path& path) {
  const std::string bytes = read_text_file(path);
  require_whole_png(bytes, path);
  const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  cv::Mat image;
  try {
    image = cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& exception) {
    fail("{}: the PNG image cannot be decoded: {}", path.string(), exception.err);
  }
  if (image.empty()) fail("{}: the PNG image cannot be decoded", path.string());
  return image;
}

std::string kind_of(const cv::Mat& image) {
  const int bits = static_cast<int>(image.elemSize1()) * 8;
  return fmt::format("{} channel(s) of {} bits", image.channels(), bits);
}

template <class T>
Image<T> read_single_channel(const std::filesystem::path& path) {
  const cv::Mat decoded = read_png(path);
  if (decoded.type() != cv::traits::Type<T>::value) {
    fail("{}: expected 1 channel of {} bits, found {}", path.string(), sizeof(T) * 8, kind_of(decoded));
  }
  Image<T> image(decoded.cols, decoded.rows);
  decoded.copyTo(cv_view(image));
  return image;
}

void write_encoded(const std::filesystem::path& path, const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes)) fail("{}: the image cannot be encoded", path.string());
  write_text_file(path, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

}  // namespace

Image<std::uint16_t> read_png16(const std::filesystem::path& path) {
  return read_single_channel<std::uint16_t>(path);
}

Image<std::uint8_t> read_png8(const std::filesystem::path& path) {
  return read_single_channel<std::uint8_t>(path);
}

Image<Rgb> read_png_rgb(const std::filesystem::path& path) {
  cv::Mat decoded = read_png(path);
  if (decoded.depth() != CV_8U || decoded.channels() < 3) {
    fail("{}: expected 3 channels of 8 bits, found {}", path.string(), kind_of(decoded));
  }
  cv::cvtColor(decoded, decoded, decoded.channels() == 4 ? cv::COLOR_BGRA2RGB : cv::COLOR_BGR2RGB);
  Image<Rgb> image(decoded.cols, decoded.rows);
  for (int row = 0; row < decoded.rows; ++row) {
    const auto* source = decoded.ptr<cv::Vec3b>(row);
    std::ranges::transform(source, source + decoded.cols, image.row(row).begin(), [](const cv::Vec3b& pixel) {
      return Rgb{pixel[0], pixel[1], pixel[2]};
    });
  }
  return image;
}

void write_png(const std::filesystem::path& path, const Image<std::uint16_t>& image) {
  write_encoded(path, cv_view(image));
}

void write_png(const std::filesystem::path& path, const Image<std::uint8_t>& image) {
  write_encoded(path, cv_view(image));
}

void write_png(const std::filesystem::path& path, const Image<Rgb>& image) {
  cv::Mat_<cv::Vec3b> encoded(image.height(), image.width());
  for (int row = 0; row < image.height(); ++row) {
    std::ranges::transform(image.row(row), encoded[row],
                           [](const Rgb& pixel) { return cv::Vec3b(pixel.blue, pixel.green, pixel.red); });
  }
  write_encoded(path, encoded);
}

}  // namespace knuckle
