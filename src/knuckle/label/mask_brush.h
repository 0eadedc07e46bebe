// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "knuckle/core/frame.h"

namespace knuckle {

/// A stroke of the brush over an image.
struct BrushStroke {
  std::vector<std::array<double, 2>> points;  ///< the way of its middle, in pixel-centre coordinates [px]
  double radius_px = 4.0;                     ///< [0.5, 100]
  bool erases = false;                        ///< takes pixels away instead
};

inline constexpr std::size_t kMostStrokePoints = 256;  ///< that a message may have
inline constexpr double kSmallestBrushPx = 0.5;        ///< least radius [px]
inline constexpr double kLargestBrushPx = 100.0;       ///< largest radius [px]

/// Paints pixels whose centres lie within the radius of the stroke's way; what lies outside of the image is
/// not painted.
void paint(const BrushStroke& stroke, Image<std::uint8_t>& pixels);

/// The pixels whose measured points lie within the flesh of a hand whose 22 landmarks are there [mm], or at
/// most `margin_mm` outside of it: 1, others 0. `points` are in the camera's coordinates.
Image<std::uint8_t> pixels_near_flesh(const Frame& frame, const std::array<Point3, kSupersetSize>& points,
                                      double margin_mm = 8.0);

}  // namespace knuckle
