// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/depth_offsets.h"

#include <numbers>

#include "knuckle/core/error.h"
#include "knuckle/core/portable_math.h"

namespace knuckle {

void OffsetOptions::visit(OptionVisitor& visitor) {
  visitor.real("nearest_offset_mm", nearest_offset_mm, open_closed(0, kMostOffset));
  visitor.real("farthest_offset_mm", farthest_offset_mm, open_closed(0, kMostOffset));
  visitor.integer("offsets_per_node", offsets_per_node, closed(2, 4096));
}

DepthOffset drawn_offset(const OffsetOptions& options, Random& random) {
  const double ratio = options.farthest_offset_mm / options.nearest_offset_mm;
  const double length = options.nearest_offset_mm * portable_pow(ratio, random.uniform());
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  return {static_cast<std::int16_t>(std::lround(length * portable_cos(angle))),
          static_cast<std::int16_t>(std::lround(length * portable_sin(angle)))};
}

void OffsetScale::append_to(std::vector<std::byte>& message) const {
  append_value(message, std::uint8_t{is_projective_});
  append_value(message, x_);
  append_value(message, y_);
}

OffsetScale OffsetScale::read(MessageReader& reader) {
  const auto projective = reader.value<std::uint8_t>();
  OffsetScale scale{Camera{}};
  scale.is_projective_ = projective == 1;
  scale.x_ = reader.value<float>();
  scale.y_ = reader.value<float>();
  if (projective > 1 || !(scale.x_ >= 0.0F) || !(scale.y_ >= 0.0F)) {
    fail("a worker's message: no camera has the scale {} and {} (kind {})", scale.x_, scale.y_, projective);
  }
  return scale;
}

BorderedDepth::BorderedDepth(const Image<float>& depth_mm)
    : width_(depth_mm.width()),
      height_(depth_mm.height()),
      pixels_(static_cast<std::size_t>(width_ + 2) * static_cast<std::size_t>(height_ + 2), kFarDepth) {
  for (int row = 0; row < height_; ++row) {
    std::int16_t* target = pixels_.data() + (row + 1) * stride() + 1;
    for (const float depth : depth_mm.row(row)) *target++ = stored_depth(depth);
  }
}

}  // namespace knuckle
