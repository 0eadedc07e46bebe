// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/portable_math.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace knuckle {
namespace {

/// Power series are summed from their highest term, with one rounding after each operation.
template <std::size_t kTerms>
double series(double z, const std::array<double, kTerms>& coefficients) {
  double sum = 0.0;
  for (std::size_t i = kTerms; i-- > 0;) sum = sum * z + coefficients[i];
  return sum;
}

// Constants in parts with trailing zeros, so that small whole multiples of all but the last part are exact.
constexpr double kHalfPiHigh = 0x1.921fb544p0;
constexpr double kHalfPiMiddle = 0x1.0b4611a6p-34;
constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;
constexpr double kLog2High = 0x1.62e42feep-1;
constexpr double kLog2Low = 0x1.a39ef35793c76p-33;

/// What is left of an angle in [-pi/4, pi/4], and how many quarter turns were taken away.
struct ReducedAngle {
  double rest;
  int quarter;  // 0 to 3
};

ReducedAngle reduced(double angle) {
  const double quarters = std::nearbyint(angle * (2.0 / std::numbers::pi));
  const double rest = ((angle - quarters * kHalfPiHigh) - quarters * kHalfPiMiddle) - quarters * kHalfPiLow;
  return {rest, static_cast<int>(static_cast<long long>(quarters) & 3)};
}

/// Taylor's series in [-pi/4, pi/4].
double sin_near_zero(double x) {
  constexpr std::array kTerms = {-1.0 / 6,
                                 1.0 / 120,
                                 -1.0 / 5040,
                                 1.0 / 362880,
                                 -1.0 / 39916800,
                                 1.0 / 6227020800.0,
                                 -1.0 / 1307674368000.0,
                                 1.0 / 355687428096000.0};
  const double z = x * x;
  return x + x * z * series(z, kTerms);
}

double cos_near_zero(double x) {
  constexpr std::array kTerms = {1.0 / 24,
                                 -1.0 / 720,
                                 1.0 / 40320,
                                 -1.0 / 3628800,
                                 1.0 / 479001600,
                                 -1.0 / 87178291200.0,
                                 1.0 / 20922789888000.0,
                                 -1.0 / 6402373705728000.0};
  const double z = x * x;
  return 1.0 - (0.5 * z - z * z * series(z, kTerms));
}

double sin_of_quarter(const ReducedAngle& angle, int quarter) {
  switch (quarter & 3) {
    case 0:
      return sin_near_zero(angle.rest);
    case 1:
      return cos_near_zero(angle.rest);
    case 2:
      return -sin_near_zero(angle.rest);
    default:
      return -cos_near_zero(angle.rest);
  }
}

/// In [0, 1]. Halving the angle twice leaves a tangent below 0.2, where the series is short.
double atan_to_one(double tangent) {
  constexpr std::array kTerms = {-1.0 / 3,  1.0 / 5,  -1.0 / 7,  1.0 / 9,  -1.0 / 11, 1.0 / 13,
                                 -1.0 / 15, 1.0 / 17, -1.0 / 19, 1.0 / 21, -1.0 / 23};
  double half = tangent;
  for (int i = 0; i < 2; ++i) half = half / (1.0 + std::sqrt(1.0 + half * half));
  const double z = half * half;
  return 4.0 * (half + half * z * series(z, kTerms));
}

}  // namespace

double portable_sin(double angle) {
  const ReducedAngle rest = reduced(angle);
  return sin_of_quarter(rest, rest.quarter);
}

double portable_cos(double angle) {
  const ReducedAngle rest = reduced(angle);
  return sin_of_quarter(rest, rest.quarter + 1);
}

double portable_log(double value) {
  if (value == 0.0) return -std::numeric_limits<double>::infinity();
  int exponent = 0;
  double part = std::frexp(value, &exponent);
  if (part < 0.5 * std::numbers::sqrt2) {  // so that it lies around 1
    part *= 2.0;
    --exponent;
  }
  // log(part) = 2 artanh(s), with |s| < 0.172
  constexpr std::array kTerms = {1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9,  1.0 / 11,
                                 1.0 / 13, 1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21};
  const double s = (part - 1.0) / (part + 1.0);
  const double z = s * s;
  return exponent * kLog2High + (2.0 * s + (2.0 * s * z * series(z, kTerms) + exponent * kLog2Low));
}

double portable_exp(double exponent) {
  constexpr double kOutOfRange = 800.0;
  const double x = std::clamp(exponent, -kOutOfRange, kOutOfRange);
  const double twos = std::nearbyint(x / std::numbers::ln2);
  const double rest = (x - twos * kLog2High) - twos * kLog2Low;  // within log(2) / 2
  constexpr std::array kTerms = {1.0 / 2,       1.0 / 6,        1.0 / 24,        1.0 / 120,
                                 1.0 / 720,     1.0 / 5040,     1.0 / 40320,     1.0 / 362880,
                                 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800.0};
  return std::ldexp(1.0 + (rest + rest * rest * series(rest, kTerms)), static_cast<int>(twos));
}

double portable_pow(double base, double exponent) {
  return portable_exp(exponent * portable_log(base));
}

double portable_atan2(double y, double x) {
  const double larger = std::max(std::abs(x), std::abs(y));
  if (larger == 0.0) return 0.0;
  double angle = atan_to_one(std::min(std::abs(x), std::abs(y)) / larger);
  if (std::abs(y) > std::abs(x)) angle = 0.5 * std::numbers::pi - angle;
  if (x < 0.0) angle = std::numbers::pi - angle;
  return std::copysign(angle, y);
}

double portable_acos(double cosine) {
  return portable_atan2(std::sqrt((1.0 - cosine) * (1.0 + cosine)), cosine);
}

double portable_asin(double sine) {
  return portable_atan2(sine, std::sqrt((1.0 - sine) * (1.0 + sine)));
}

}  // namespace knuckle
