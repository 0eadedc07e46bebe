// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "knuckle/core/camera.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/image.h"
#include "knuckle/core/options.h"
#include "knuckle/core/random.h"
#include "knuckle/core/worker_messages.h"

namespace knuckle {

/// Depths as features see them: whole millimetres in 16 bits. What is out of the image, was not measured, or
/// lies farther away reads as kFarDepth: all three are 'nothing near here'.
inline constexpr std::int16_t kFarDepth = 10000;

/// The depth as it is stored: whole millimetres from 1 on, or kFarDepth.
inline std::int16_t stored_depth(float depth_mm) {
  if (!is_measured(depth_mm) || depth_mm >= static_cast<float>(kFarDepth)) return kFarDepth;
  return static_cast<std::int16_t>(std::max(1.0F, std::floor(depth_mm + 0.5F)));
}

/// An offset from a pixel, in millimetres on the plane through its point and parallel to the image. For a
/// projective camera it is d^-1 * offset * f pixels: equation 1's offset in pixels times millimetres, less
/// the focal length. So trees mean lengths, and serve cameras of any resolution.
struct DepthOffset {
  std::int16_t x = 0;
  std::int16_t y = 0;

  bool operator==(const DepthOffset&) const = default;
};

/// The split feature of equation 1 (Riegler et al. 2015), with the second probe free as in Shotton et al.
/// 2011: D(u + d^-1 first) - D(u + d^-1 second). With second = (0, 0) it is the equation as printed.
struct OffsetPair {
  std::int16_t first_x = 0;
  std::int16_t first_y = 0;
  std::int16_t second_x = 0;
  std::int16_t second_y = 0;

  bool operator==(const OffsetPair&) const = default;

  /// Shows the columns that a file keeps it in: calls visit(name, pointer to member).
  template <class Visit>
  static void for_each_column(Visit visit) {
    visit("node_first_x", &OffsetPair::first_x);
    visit("node_first_y", &OffsetPair::first_y);
    visit("node_second_x", &OffsetPair::second_x);
    visit("node_second_y", &OffsetPair::second_y);
  }
};

/// Largest offset, either way [mm].
inline constexpr int kMostOffset = 4000;

/// Where offsets are drawn from: directions evenly, lengths evenly in their logarithm.
struct OffsetOptions {
  double nearest_offset_mm = 4.0;     ///< (0, 4000] [mm]
  double farthest_offset_mm = 600.0;  ///< (0, 4000] [mm], at least the nearest
  int offsets_per_node = 256;         ///< pool that the candidates of a node combine, [2, 4096]

  void visit(OptionVisitor& visitor);
};

/// A random offset, rounded to whole millimetres.
DepthOffset drawn_offset(const OffsetOptions& options, Random& random);

/// Pixels a millimetre at some depth, in units of 2^-14: whole numbers, so that every machine and every way
/// of computing reads the same pixels. At most 16 pixels per millimetre.
struct PixelScale {
  static constexpr int kBits = 14;
  static constexpr std::int32_t kMost = 16 << kBits;

  std::int32_t x = 0;
  std::int32_t y = 0;
};

/// The scale of a camera as a function of depth. The sign of a focal length is left out: offsets count in
/// image directions.
class OffsetScale {
 public:
  explicit OffsetScale(const Camera& camera)
      : is_projective_(camera.model == CameraModel::projective),
        x_(static_cast<float>(std::abs(camera.fx) * (1 << PixelScale::kBits))),
        y_(static_cast<float>(std::abs(camera.fy) * (1 << PixelScale::kBits))) {}

  /// `depth_mm` as stored_depth gives it.
  PixelScale at(std::int16_t depth_mm) const {
    const float divisor = is_projective_ ? static_cast<float>(depth_mm) : 1.0F;
    return {rounded(x_ / divisor), rounded(y_ / divisor)};
  }

  /// What append_to adds to a message to another worker.
  static constexpr std::size_t kMessageBytes = 1 + 2 * sizeof(float);
  void append_to(std::vector<std::byte>& message) const;
  /// Reads what append_to wrote. Throws an Error where it is no camera's.
  static OffsetScale read(MessageReader& reader);

 private:
  static std::int32_t rounded(float scale) {
    return static_cast<std::int32_t>(std::min(scale, static_cast<float>(PixelScale::kMost)));
  }

  bool is_projective_;
  float x_;
  float y_;
};

/// The pixel that lies `offset_mm` from `pixel`, along one axis.
inline int shifted(int pixel, int offset_mm, std::int32_t scale) {
  constexpr std::int32_t kHalf = 1 << (PixelScale::kBits - 1);
  return pixel + ((offset_mm * scale + kHalf) >> PixelScale::kBits);
}

/// The feature of one pixel. `depth(column, row)` gives stored depths, kFarDepth out of the image.
template <class Depth>
std::int16_t offset_feature(const Depth& depth, int column, int row, PixelScale scale,
                            const OffsetPair& pair) {
  const std::int16_t first =
      depth(shifted(column, pair.first_x, scale.x), shifted(row, pair.first_y, scale.y));
  const std::int16_t second =
      depth(shifted(column, pair.second_x, scale.x), shifted(row, pair.second_y, scale.y));
  return static_cast<std::int16_t>(first - second);
}

/// A depth image in 16 bits with a border of kFarDepth, a pixel wide: what lies farther out is read there.
class BorderedDepth {
 public:
  explicit BorderedDepth(const Image<float>& depth_mm);

  int width() const { return width_; }
  int height() const { return height_; }
  int stride() const { return width_ + 2; }
  std::int16_t operator()(int column, int row) const {
    return data()[std::clamp(row, -1, height_) * stride() + std::clamp(column, -1, width_)];
  }
  /// Pixel (0, 0).
  const std::int16_t* data() const { return pixels_.data() + stride() + 1; }

 private:
  int width_;
  int height_;
  std::vector<std::int16_t> pixels_;
};

}  // namespace knuckle
