// SPDX-License-Identifier: Apache-2.0
// Private to the module: what its inner loops are written in.
#pragma once

#include <cstring>

#include "knuckle/net/half.h"

#if defined(__AVX2__) && defined(__FMA__) && defined(__F16C__)
#include <immintrin.h>
#define KNUCKLE_HAS_AVX2 1
#else
#define KNUCKLE_HAS_AVX2 0
#endif

namespace knuckle {

/// Numbers worked on at once.
inline constexpr int kLanes = 8;

/// Eight numbers that are worked on together: a register of AVX; elsewhere what the compiler makes of it.
typedef float Float8 __attribute__((vector_size(kLanes * sizeof(float))));

/// The least multiple of eight that is not below `count`.
constexpr int whole_lanes(int count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

/// Reads eight numbers, from any address.
inline Float8 load8(const float* from) {
  Float8 values;
  std::memcpy(&values, from, sizeof(values));
  return values;
}

/// Writes eight numbers, to any address.
inline void store8(float* to, Float8 values) {
  std::memcpy(to, &values, sizeof(values));
}

/// The same number eight times.
inline Float8 all8(float value) {
  return Float8{value, value, value, value, value, value, value, value};
}

/// The larger number; `b` where one is NaN.
inline Float8 larger8(Float8 a, Float8 b) {
  return a > b ? a : b;
}

/// a * b + c, rounded once where the processor can.
inline Float8 multiply_add(Float8 a, Float8 b, Float8 c) {
#if KNUCKLE_HAS_AVX2
  return _mm256_fmadd_ps(a, b, c);
#else
  return a * b + c;
#endif
}

/// Eight numbers of half precision in single.
inline Float8 load_halves(const Half* from) {
#if KNUCKLE_HAS_AVX2
  __m128i bits;
  std::memcpy(&bits, from, sizeof(bits));
  return _mm256_cvtph_ps(bits);
#else
  Float8 values{};
  for (int i = 0; i < kLanes; ++i) values[i] = float_of_half(from[i]);
  return values;
#endif
}

}  // namespace knuckle
