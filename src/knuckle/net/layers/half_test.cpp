// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/half.h"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/net/layers/float_lanes.h"

namespace knuckle {
namespace {

/// By the format's definition.
double reference(Half half) {
  const int exponent = (half >> 10) & 31;
  const int fraction = half & 1023;
  const double size = exponent == 0 ? std::ldexp(fraction, -24) : std::ldexp(1024 + fraction, exponent - 25);
  return (half & 0x8000) != 0 ? -size : size;
}

TEST(Half, EveryOneHasItsValueAndComesBack) {
  for (int bits = 0; bits < 65536; ++bits) {
    const auto half = static_cast<Half>(bits);
    if (!is_finite(half)) continue;
    ASSERT_EQ(float_of_half(half), reference(half)) << bits;
    ASSERT_EQ(half_of_float(float_of_half(half)), half) << bits;
  }
}

TEST(Half, RoundsToTheNearestAndThereToTheEvenOne) {
  Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const auto value = static_cast<float>(std::ldexp(random.uniform(-1.0, 1.0), int(random.below(42)) - 26));
    const Half half = half_of_float(value);
    const double error = std::abs(reference(half) - value);
    EXPECT_LE(error, std::abs(reference(static_cast<Half>(half + 1)) - value)) << value;
    if ((half & 0x7FFF) != 0) {
      EXPECT_LE(error, std::abs(reference(static_cast<Half>(half - 1)) - value)) << value;
    }
  }
  EXPECT_EQ(half_of_float(1.0f + 0x1p-11f), half_of_float(1.0f));
  EXPECT_EQ(half_of_float(1.0f + 0x3p-11f), half_of_float(1.0f + 0x1p-9f));
  EXPECT_EQ(half_of_float(0x1p-25f), 0);
  EXPECT_EQ(half_of_float(0x3p-25f), 2);
}

TEST(Half, WhatIsNotFiniteStaysSo) {
  const float infinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(float_of_half(half_of_float(-infinity)), -infinity);
  EXPECT_EQ(half_of_float(65519.0f), 0x7BFF);
  EXPECT_EQ(half_of_float(65520.0f), 0x7C00);
  EXPECT_EQ(half_of_float(1e30f), 0x7C00);
  EXPECT_TRUE(std::isnan(float_of_half(half_of_float(std::numeric_limits<float>::quiet_NaN()))));
  EXPECT_FALSE(is_finite(0x7C00));
  EXPECT_FALSE(is_finite(0xFE00));
  EXPECT_TRUE(is_finite(0x7BFF));
}

TEST(FloatLanes, ReadsHalvesAsTheyAre) {
  for (int first = 0; first < 65536; first += kLanes) {
    std::array<Half, kLanes> halves{};
    for (int i = 0; i < kLanes; ++i) halves[i] = static_cast<Half>(first + i);
    const FloatLanes values = load_halves(halves.data());
    for (int i = 0; i < kLanes; ++i) {
      if (is_finite(halves[i])) {
        ASSERT_EQ(values[i], float_of_half(halves[i]));
      }
    }
  }
}

}  // namespace
}  // namespace knuckle
