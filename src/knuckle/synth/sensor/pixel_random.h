// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace knuckle {

/// What a pixel's random numbers are for: each use has numbers of its own.
enum class PixelUse : std::uint32_t { range_noise, grain, flying, lateral, hole, infrared, matching };

/// Pixels that share one block of random words.
inline constexpr std::size_t kPixelsPerBlock = 8;

/// 16 random bits for each of eight neighbouring pixels (8 block, ..., 8 block + 7, counted along the rows):
/// a function of the frame's seed, the use and the place alone.
std::array<std::uint16_t, kPixelsPerBlock> block_bits(std::uint64_t seed, PixelUse use, std::uint32_t block);

/// The same as standard normal numbers.
std::array<float, kPixelsPerBlock> block_normals(std::uint64_t seed, PixelUse use, std::uint32_t block);

/// 128 random bits for one pixel, where a few pixels of an image need some.
std::array<std::uint32_t, 4> pixel_words(std::uint64_t seed, PixelUse use, std::uint32_t pixel);

/// A standard normal number from 16 random bits: one of 65,536 equally likely values, without a logarithm. It
/// ends at 4.3 deviations.
float normal_from_bits(std::uint16_t bits);

/// Uniform in [0, 1) from 32 random bits.
inline float uniform_from_bits(std::uint32_t bits) {
  return static_cast<float>(bits >> 8) * 0x1.0p-24f;
}

}  // namespace knuckle
