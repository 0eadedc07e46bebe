// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/v4l2_format.h"

#include <array>
#include <cassert>

#include <linux/videodev2.h>

#include "knuckle/core/limits.h"
#include "knuckle/data/readers/depth_image.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 4> kV4l2FormatNames{"auto", "z16", "inzi", "y16"};
constexpr std::array kV4l2DepthFormats{
    V4l2DepthFormat{"z16", V4L2_PIX_FMT_Z16, 1, 1.0},
    V4l2DepthFormat{"inzi", V4L2_PIX_FMT_INZI, 2, 0.125},
    V4l2DepthFormat{"y16", V4L2_PIX_FMT_Y16, 1, 1.0},
};

Image<std::uint16_t> little_endian_image(std::span<const std::uint8_t> bytes, const V4l2Layout& layout) {
  Image<std::uint16_t> image(layout.width, layout.height);
  for (int row = 0; row < layout.height; ++row) {
    const std::uint8_t* byte = bytes.data() + layout.line_bytes * static_cast<std::size_t>(row);
    for (std::uint16_t& pixel : image.row(row)) {
      pixel = static_cast<std::uint16_t>(byte[0] | byte[1] << 8);
      byte += 2;
    }
  }
  return image;
}

}  // namespace

void V4l2Options::visit(OptionVisitor& visitor) {
  constexpr double kHighestRate = 1000.0;
  constexpr double kDay = 86400.0;
  visitor.choice("format", format, kV4l2FormatNames);
  visitor.integer("width", width, closed(0, limits::kImageSide));
  visitor.integer("height", height, closed(0, limits::kImageSide));
  visitor.real("rate", rate_hz, closed(0, kHighestRate));
  visitor.real("depth_unit_mm", depth_unit_mm, closed(0, limits::kDepthUnitMm));
  visitor.real("timeout_s", timeout_s, closed(0.1, 3600));
  visitor.real("wait_s", wait_s, closed(0, kDay));
  intrinsics.visit(visitor);
}

std::span<const V4l2DepthFormat> v4l2_depth_formats() {
  return kV4l2DepthFormats;
}

std::string four_letters(std::uint32_t code) {
  std::string letters;
  for (int i = 0; i < 4; ++i) letters += static_cast<char>(code >> (8 * i) & 0x7F);
  letters.erase(letters.find_last_not_of(' ') + 1);
  return letters;
}

V4l2Images decode_v4l2(std::span<const std::uint8_t> bytes, const V4l2Layout& layout, double depth_unit_mm) {
  assert(bytes.size() >= layout.frame_bytes());
  const std::size_t image_bytes = layout.frame_bytes() / static_cast<std::size_t>(layout.format.images);
  V4l2Images images;
  if (layout.format.images == 2) images.infrared = little_endian_image(bytes, layout);
  const auto depth = bytes.subspan(image_bytes * static_cast<std::size_t>(layout.format.images - 1));
  images.depth_mm = depth_from_counts(little_endian_image(depth, layout), depth_unit_mm);
  return images;
}

}  // namespace knuckle
