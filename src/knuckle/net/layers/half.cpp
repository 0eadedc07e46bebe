// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/half.h"

#include <bit>
#include <cmath>

namespace knuckle {
namespace {

constexpr int kHalfFraction = 10;  // bits of the fraction
constexpr int kFloatFraction = 23;
constexpr int kBiasDifference = 127 - 15;
constexpr std::uint32_t kHalfInfinity = 0x7C00;
constexpr std::uint32_t kFloatInfinity = 0x7F800000;
constexpr int kSmallestExponent = -24;  // of the smallest half above 0

}  // namespace

float float_of_half(Half half) {
  const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000) << 16;
  const std::uint32_t exponent = (half & kHalfInfinity) >> kHalfFraction;
  const std::uint32_t fraction = half & 0x3FF;
  if (exponent == 0) {  // zero, or subnormal
    const float value = std::ldexp(static_cast<float>(fraction), kSmallestExponent);
    return sign != 0 ? -value : value;
  }
  const std::uint32_t fraction_bits = fraction << (kFloatFraction - kHalfFraction);
  if (exponent == kHalfInfinity >> kHalfFraction) {
    return std::bit_cast<float>(sign | kFloatInfinity | fraction_bits);
  }
  return std::bit_cast<float>(sign | ((exponent + kBiasDifference) << kFloatFraction) | fraction_bits);
}

Half half_of_float(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const auto sign = static_cast<Half>((bits >> 16) & 0x8000);
  if (std::isnan(value)) return sign | 0x7E00;
  const float size = std::abs(value);
  if (size >= 65520.0f) return sign | kHalfInfinity;  // half a step beyond the largest
  if (size < 0x1p-14f) {                              // subnormal: whole steps of 2^-24; adding rounds
    constexpr float kStepIsOne = 0.5f;                // 2^-24 is the last bit of a float in [0.5, 1)
    const std::uint32_t steps =
        std::bit_cast<std::uint32_t>(size + kStepIsOne) - std::bit_cast<std::uint32_t>(kStepIsOne);
    return static_cast<Half>(sign | steps);
  }
  constexpr int kDropped = kFloatFraction - kHalfFraction;
  std::uint32_t rounded = bits & 0x7FFFFFFF;
  rounded += (1U << (kDropped - 1)) - 1 + ((rounded >> kDropped) & 1);  // to the even one
  return static_cast<Half>(sign | ((rounded >> kDropped) - (kBiasDifference << kHalfFraction)));
}

}  // namespace knuckle
