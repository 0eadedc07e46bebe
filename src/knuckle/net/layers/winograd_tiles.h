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

/// F(4 x 4, 3 x 3), section 4.3: 36 multiplications for 16 outputs instead of 144. The polynomials are
/// evaluated at 0, +-5/8, +-3/2 and infinity in place of the paper's 0, +-1, +-2: powers nearer to 1 halve
/// the rounding errors (Barabasz et al., "Error Analysis and Improving the Accuracy of Winograd Convolution
/// for Deep Neural Networks", 2020, look for such points). All constants of the images' side are exact.
struct Tile4 {
  static constexpr int kOutputs = 4;
  static constexpr int kSide = 6;

  template <class Number>
  static std::array<Number, kSide> input(const std::array<Number, kSide>& d) {
    const Number even = d[4] - kFar2 * d[2];
    const Number odd = kNear * (d[3] - kFar2 * d[1]);
    const Number even2 = d[4] - kNear2 * d[2];
    const Number odd2 = kFar * (d[3] - kNear2 * d[1]);
    return {kProduct * d[0] - kSum * d[2] + d[4], even + odd, even - odd, even2 + odd2, even2 - odd2,
            kProduct * d[1] - kSum * d[3] + d[5]};
  }
  static std::array<double, kSide> kernel(const std::array<double, 3>& g) {
    constexpr double kOfNear = 2.0 * kNear2 * (kNear2 - kFar2);
    constexpr double kOfFar = 2.0 * kFar2 * (kFar2 - kNear2);
    return {g[0] / kProduct,
            (g[0] + kNear * g[1] + kNear2 * g[2]) / kOfNear,
            (g[0] - kNear * g[1] + kNear2 * g[2]) / kOfNear,
            (g[0] + kFar * g[1] + kFar2 * g[2]) / kOfFar,
            (g[0] - kFar * g[1] + kFar2 * g[2]) / kOfFar,
            g[2]};
  }
  template <class Number>
  static std::array<Number, kOutputs> output(const std::array<Number, kSide>& m) {
    const Number sum = m[1] + m[2];
    const Number difference = kNear * (m[1] - m[2]);
    const Number sum2 = m[3] + m[4];
    const Number difference2 = kFar * (m[3] - m[4]);
    return {m[0] + sum + sum2, difference + difference2, kNear2 * sum + kFar2 * sum2,
            kNear2 * difference + kFar2 * difference2 + m[5]};
  }

 private:
  static constexpr float kNear = 0.625F;
  static constexpr float kFar = 1.5F;
  static constexpr float kNear2 = kNear * kNear;
  static constexpr float kFar2 = kFar * kFar;
  static constexpr float kSum = kNear2 + kFar2;
  static constexpr float kProduct = kNear2 * kFar2;
};

}  // namespace knuckle
