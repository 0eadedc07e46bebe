// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace knuckle {

/// Eight lanes, in the vector extension of GCC and Clang: arithmetic is by lane, with the same bits on every
/// machine.
using Int32x8 [[gnu::vector_size(32)]] = std::int32_t;
using Float32x8 [[gnu::vector_size(32)]] = float;

inline constexpr int kSimdLanes = 8;

inline Float32x8 to_float(Int32x8 values) {
  return __builtin_convertvector(values, Float32x8);
}

/// The sum of the lanes, by halves.
inline float lane_sum(Float32x8 values) {
  return ((values[0] + values[4]) + (values[2] + values[6])) +
         ((values[1] + values[5]) + (values[3] + values[7]));
}

}  // namespace knuckle
