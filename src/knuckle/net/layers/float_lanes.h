// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks: what its inner loops are written in.
#pragma once

#include <cstring>

#include "knuckle/net/layers/half.h"

#if defined(__AVX512F__) || defined(__AVX2__)
#include <immintrin.h>
#endif

namespace knuckle {

/// Numbers worked on at once: a register of AVX-512, or of AVX; elsewhere what the compiler makes of it.
#if defined(__AVX512F__)
inline constexpr int kLanes = 16;
#else
inline constexpr int kLanes = 8;
#endif

/// kLanes numbers that are worked on together.
typedef float FloatLanes __attribute__((vector_size(kLanes * sizeof(float))));

/// The least multiple of kLanes that is not below `count`.
constexpr int whole_lanes(int count) {
  return (count + kLanes - 1) / kLanes * kLanes;
}

/// Reads kLanes numbers, from any address.
inline FloatLanes load_lanes(const float* from) {
  FloatLanes values;
  std::memcpy(&values, from, sizeof(values));
  return values;
}

/// Writes kLanes numbers, to any address.
inline void store_lanes(float* to, FloatLanes values) {
  std::memcpy(to, &values, sizeof(values));
}

/// The same number in all lanes.
inline FloatLanes all_lanes(float value) {
  return value - FloatLanes{};  // minus 0 leaves each number as it is, -0 too
}

/// The larger number; `b` where one is NaN.
inline FloatLanes larger_lanes(FloatLanes a, FloatLanes b) {
  return a > b ? a : b;
}

/// a * b + c, rounded once where the processor can.
inline FloatLanes multiply_add(FloatLanes a, FloatLanes b, FloatLanes c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_ps(a, b, c);
#elif defined(__AVX2__) && defined(__FMA__)
  return _mm256_fmadd_ps(a, b, c);
#else
  return a * b + c;
#endif
}

/// kLanes numbers of half precision in single.
inline FloatLanes load_halves(const Half* from) {
#if defined(__AVX512F__)
  __m256i bits;
  std::memcpy(&bits, from, sizeof(bits));
  return _mm512_cvtph_ps(bits);
#elif defined(__AVX2__) && defined(__F16C__)
  __m128i bits;
  std::memcpy(&bits, from, sizeof(bits));
  return _mm256_cvtph_ps(bits);
#else
  FloatLanes values{};
  for (int i = 0; i < kLanes; ++i) values[i] = float_of_half(from[i]);
  return values;
#endif
}

}  // namespace knuckle
