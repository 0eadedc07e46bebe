// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros_image.h"

#include <bit>

#include "knuckle/core/error.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/image_size.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::string_view kMetres = "32FC1";

std::uint32_t bytes_per_pixel(std::string_view encoding) {
  if (encoding == kMetres) return 4;
  return encoding == "mono8" || encoding == "8UC1" ? 1 : 2;
}

void require_sizes(const RosImage& image, std::string_view where) {
  for (const std::uint32_t side : {image.width, image.height}) {
    if (side < 1 || side > limits::kImageSide) {
      fail("{}: has an image of {}x{} pixels, expected 1 to {} a side", where, image.width, image.height,
           limits::kImageSide);
    }
  }
  require_image_size({image.width, image.height}, where);
  const std::uint64_t row_bytes = std::uint64_t{image.width} * bytes_per_pixel(image.encoding);
  if (image.step < row_bytes) {
    fail("{}: has rows of {} bytes, expected at least {}", where, image.step, row_bytes);
  }
  const std::uint64_t expected = std::uint64_t{image.step} * image.height;
  if (image.pixels.size() != expected) {
    fail("{}: has an image of {} bytes, expected {}", where, image.pixels.size(), expected);
  }
}

std::uint32_t number_at(const std::uint8_t* bytes, std::uint32_t count, bool is_big_endian) {
  std::uint32_t value = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    value = value << 8 | bytes[is_big_endian ? i : count - 1 - i];
  }
  return value;
}

float measured_or_0(float depth_mm) {
  return is_measured(depth_mm) ? depth_mm : 0.0f;
}

}  // namespace

bool is_depth_encoding(std::string_view encoding) {
  return encoding == "16UC1" || encoding == "mono16" || encoding == kMetres;
}

Image<float> depth_mm_of(const RosImage& image, double unit_mm, std::string_view where) {
  if (!is_depth_encoding(image.encoding)) {
    fail("{}: has images of encoding '{:.40}', expected depth: 16UC1, mono16 or 32FC1", where,
         printable(image.encoding));
  }
  require_sizes(image, where);
  const bool is_metres = image.encoding == kMetres;
  const std::uint32_t count = bytes_per_pixel(image.encoding);
  Image<float> depth_mm(static_cast<int>(image.width), static_cast<int>(image.height));
  for (std::uint32_t row = 0; row < image.height; ++row) {
    const std::uint8_t* from = image.pixels.data() + std::size_t{row} * image.step;
    for (float& depth : depth_mm.row(static_cast<int>(row))) {
      const std::uint32_t value = number_at(from, count, image.is_big_endian);
      depth = is_metres ? measured_or_0(1000.0f * std::bit_cast<float>(value))
                        : static_cast<float>(value * unit_mm);
      from += count;
    }
  }
  return depth_mm;
}

bool is_infrared_encoding(std::string_view encoding) {
  return encoding == "mono8" || encoding == "8UC1" || encoding == "mono16" || encoding == "16UC1";
}

Image<std::uint16_t> infrared_of(const RosImage& image, std::string_view where) {
  if (!is_infrared_encoding(image.encoding)) {
    fail("{}: has images of encoding '{:.40}', expected infrared: mono8, 8UC1, mono16 or 16UC1", where,
         printable(image.encoding));
  }
  require_sizes(image, where);
  const std::uint32_t count = bytes_per_pixel(image.encoding);
  Image<std::uint16_t> infrared(static_cast<int>(image.width), static_cast<int>(image.height));
  for (std::uint32_t row = 0; row < image.height; ++row) {
    const std::uint8_t* from = image.pixels.data() + std::size_t{row} * image.step;
    for (std::uint16_t& pixel : infrared.row(static_cast<int>(row))) {
      pixel = static_cast<std::uint16_t>(number_at(from, count, image.is_big_endian));
      from += count;
    }
  }
  return infrared;
}

}  // namespace knuckle
