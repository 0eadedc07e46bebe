// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace knuckle {

/// A number in half precision (IEEE 754 binary16), as bits.
using Half = std::uint16_t;

/// Exact; subnormal numbers, infinities and NaN included.
float float_of_half(Half half);
/// The nearest half, the even one of two; beyond 65504 infinite.
Half half_of_float(float value);

/// Neither infinite nor NaN.
inline bool is_finite(Half half) {
  constexpr Half kExponent = 0x7C00;
  return (half & kExponent) != kExponent;
}

}  // namespace knuckle
