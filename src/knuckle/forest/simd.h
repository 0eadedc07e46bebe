// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

namespace knuckle {

/// Lanes in the vector extension of GCC and Clang: arithmetic is by lane, with the same bits on every
/// machine.
using Int16x8 [[gnu::vector_size(16)]] = std::int16_t;
using Int16x16 [[gnu::vector_size(32)]] = std::int16_t;
using Int32x4 [[gnu::vector_size(16)]] = std::int32_t;
using Int32x8 [[gnu::vector_size(32)]] = std::int32_t;
using Float32x8 [[gnu::vector_size(32)]] = float;

/// Values of these two types.
inline constexpr int kSimdLanes = 8;

/// Each value as a float.
inline Float32x8 to_float(Int32x8 values) {
  return __builtin_convertvector(values, Float32x8);
}

/// The sum of the lanes, by halves.
inline float lane_sum(Float32x8 values) {
  return ((values[0] + values[4]) + (values[2] + values[6])) +
         ((values[1] + values[5]) + (values[3] + values[7]));
}

/// Writes eight rows of eight values as eight columns: target[j * stride + i] = rows[i][j].
inline void transpose_8x8(const std::int16_t* const* rows, std::ptrdiff_t offset, std::int16_t* target,
                          std::size_t stride) {
  std::array<Int16x8, 8> in;
  for (std::size_t i = 0; i < 8; ++i) std::memcpy(&in[i], rows[i] + offset, sizeof(Int16x8));
  std::array<Int16x8, 8> out;
  // Three rounds, each of which interleaves row i with row i + 4, are a transposition (a perfect shuffle,
  // thrice).
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < 4; ++i) {
      out[2 * i] = __builtin_shufflevector(in[i], in[i + 4], 0, 8, 1, 9, 2, 10, 3, 11);
      out[2 * i + 1] = __builtin_shufflevector(in[i], in[i + 4], 4, 12, 5, 13, 6, 14, 7, 15);
    }
    in = out;
  }
  for (std::size_t j = 0; j < 8; ++j) std::memcpy(target + j * stride, &in[j], sizeof(Int16x8));
}

}  // namespace knuckle
