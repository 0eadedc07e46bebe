// SPDX-License-Identifier: Apache-2.0
// Private to the module: the transforms of Lavin and Gray, "Fast Algorithms for Convolutional Neural
// Networks", CVPR 2016, along one line of a tile.
#pragma once

#include <array>

namespace knuckle {

/// F(2 x 2, 3 x 3), section 4.1: 16 multiplications for four outputs instead of 36.
struct Tile2 {
  static constexpr int kOutputs = 2;  ///< pixels a side
  static constexpr int kSide = 4;     ///< of the input

  /// B^T d.
  template <class Number>
  static std::array<Number, kSide> input(const std::array<Number, kSide>& d) {
    return {d[0] - d[2], d[1] + d[2], d[2] - d[1], d[1] - d[3]};
  }
  /// G g.
  static std::array<double, kSide> kernel(const std::array<double, 3>& g) {
    return {g[0], (g[0] + g[1] + g[2]) / 2, (g[0] - g[1] + g[2]) / 2, g[2]};
  }
  /// A^T m.
  template <class Number>
  static std::array<Number, kOutputs> output(const std::array<Number, kSide>& m) {
    return {m[0] + m[1] + m[2], m[1] - m[2] - m[3]};
  }
};

/// F(4 x 4, 3 x 3), section 4.3: 36 multiplications for 16 outputs instead of 144.
struct Tile4 {
  static constexpr int kOutputs = 4;
  static constexpr int kSide = 6;

  template <class Number>
  static std::array<Number, kSide> input(const std::array<Number, kSide>& d) {
    const Number even = d[4] - 4.0F * d[2];
    const Number odd = d[3] - 4.0F * d[1];
    const Number even2 = d[4] - d[2];
    const Number odd2 = 2.0F * (d[3] - d[1]);
    return {4.0F * d[0] - 5.0F * d[2] + d[4], even + odd, even - odd, even2 + odd2, even2 - odd2,
            4.0F * d[1] - 5.0F * d[3] + d[5]};
  }
  static std::array<double, kSide> kernel(const std::array<double, 3>& g) {
    return {g[0] / 4,
            -(g[0] + g[1] + g[2]) / 6,
            -(g[0] - g[1] + g[2]) / 6,
            (g[0] + 2 * g[1] + 4 * g[2]) / 24,
            (g[0] - 2 * g[1] + 4 * g[2]) / 24,
            g[2]};
  }
  template <class Number>
  static std::array<Number, kOutputs> output(const std::array<Number, kSide>& m) {
    const Number sum = m[1] + m[2];
    const Number difference = m[1] - m[2];
    const Number sum2 = m[3] + m[4];
    const Number difference2 = m[3] - m[4];
    return {m[0] + sum + sum2, difference + 2.0F * difference2, sum + 4.0F * sum2,
            difference + 8.0F * difference2 + m[5]};
  }
};

}  // namespace knuckle
