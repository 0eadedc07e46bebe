// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/core/error.h"
#include "knuckle/core/image.h"

namespace knuckle {

/// Depth in millimetres from stored whole numbers; 0 stays 0, no measurement.
Image<float> depth_from_counts(const Image<std::uint16_t>& counts, double unit_mm);

/// Depth as whole multiples of `unit_mm`, rounded; what is not a positive number becomes 0, no measurement.
/// Throws an Error that starts with `where` where a depth exceeds what 16 bits hold.
Image<std::uint16_t> counts_from_depth(const Image<float>& depth_mm, double unit_mm, std::string_view where);

/// Units of depth that cameras have [mm], from coarse to fine.
inline constexpr std::array kDepthUnitsMm{1.0, 0.5, 0.25, 0.2, 0.125, 0.1};

/// The coarsest of these in whose 16-bit multiples the depth can be kept to the bit: what `counts_from_depth`
/// makes of it, `depth_from_counts` gives back. Nothing where there is none.
std::optional<double> exact_depth_unit_mm(const Image<float>& depth_mm);

/// Whether all of the depth can be kept so in this unit.
bool is_exact_in(const Image<float>& depth_mm, double unit_mm);

/// Whether nothing is farther than 16 bits hold in this unit.
bool reaches_all(const Image<float>& depth_mm, double unit_mm);

/// A unit for depth of which nothing else is known: the exact one; else 0.1 mm, which reaches to 6.5 m, or
/// 1 mm where something is farther.
double suitable_depth_unit_mm(const Image<float>& depth_mm);

/// The same as `counts_from_depth`, but what exceeds 16 bits becomes 0, no measurement.
Image<std::uint16_t> near_counts_from_depth(const Image<float>& depth_mm, double unit_mm);

/// 1 where a pixel is not 0.
Image<std::uint8_t> mask_from_pixels(Image<std::uint8_t> pixels);

/// Throws an Error that names the file where its image is not `width` x `height`.
template <class T>
void require_size(const Image<T>& image, int width, int height, const std::filesystem::path& path) {
  if (image.width() == width && image.height() == height) return;
  fail("{}: is {}x{} pixels, expected {}x{}", path.string(), image.width(), image.height(), width, height);
}

}  // namespace knuckle
