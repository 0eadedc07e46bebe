// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/portable_math.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

constexpr double kStep = std::numeric_limits<double>::epsilon();

/// `found` against the exact value, in units in the last place of what is larger: it or `scale`.
void expect_near(double found, long double exact, double argument, double scale = 0.0) {
  const double tolerance = 6.0 * kStep * std::max(static_cast<double>(std::abs(exact)), scale);
  EXPECT_LE(std::abs(static_cast<double>(found - exact)), tolerance) << "at " << argument;
}

TEST(PortableMath, AgreesWithLongerNumbers) {
  Random random(7);
  for (int i = 0; i < 20000; ++i) {
    // Near its zeros a sine's error is that of the angle.
    const double angle = random.uniform(-50.0, 50.0);
    expect_near(portable_sin(angle), std::sin(static_cast<long double>(angle)), angle, 1e-6);
    expect_near(portable_cos(angle), std::cos(static_cast<long double>(angle)), angle, 1e-6);
    const double value = std::ldexp(random.uniform(0.5, 1.0), static_cast<int>(random.below(200)) - 100);
    expect_near(portable_log(value), std::log(static_cast<long double>(value)), value);
    const double exponent = random.uniform(-700.0, 700.0);
    expect_near(portable_exp(exponent), std::exp(static_cast<long double>(exponent)), exponent);
    const double x = random.uniform(-1.0, 1.0);
    const double y = random.uniform(-1.0, 1.0);
    expect_near(portable_atan2(y, x), std::atan2(static_cast<long double>(y), static_cast<long double>(x)),
                x);
    expect_near(portable_acos(x), std::acos(static_cast<long double>(x)), x);
    expect_near(portable_asin(x), std::asin(static_cast<long double>(x)), x);
  }
}

TEST(PortableMath, NearOneLogarithmsAreExactToo) {
  for (double off = 1e-15; off < 0.5; off *= 3.0) {
    expect_near(portable_log(1.0 + off), std::log(static_cast<long double>(1.0 + off)), off);
    expect_near(portable_log(1.0 - off), std::log(static_cast<long double>(1.0 - off)), off);
  }
}

TEST(PortableMath, EndsOfTheRanges) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(portable_sin(0.0), 0.0);
  EXPECT_EQ(portable_cos(0.0), 1.0);
  EXPECT_EQ(portable_log(1.0), 0.0);
  EXPECT_EQ(portable_log(0.0), -infinity);
  EXPECT_EQ(portable_exp(0.0), 1.0);
  EXPECT_EQ(portable_exp(1000.0), infinity);
  EXPECT_EQ(portable_exp(-1000.0), 0.0);
  EXPECT_EQ(portable_acos(1.0), 0.0);
  EXPECT_EQ(portable_acos(-1.0), std::numbers::pi);
  EXPECT_EQ(portable_asin(1.0), 0.5 * std::numbers::pi);
  EXPECT_EQ(portable_asin(-1.0), -0.5 * std::numbers::pi);
  EXPECT_EQ(portable_atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(portable_atan2(0.0, -1.0), std::numbers::pi);
  EXPECT_EQ(portable_pow(7.0, 0.0), 1.0);
  EXPECT_NEAR(portable_pow(150.0, 0.37), std::pow(150.0, 0.37), 1e-14 * std::pow(150.0, 0.37));
}

}  // namespace
}  // namespace knuckle
