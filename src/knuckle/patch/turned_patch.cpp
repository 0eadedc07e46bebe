// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/turned_patch.h"

#include <cassert>
#include <cmath>

#include "knuckle/core/portable_math.h"

namespace knuckle {
namespace {

Image<float> turned_once(const Image<float>& square) {
  const int size = square.width();
  Image<float> result(size, size);
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) result(size - 1 - v, u) = square(u, v);
  }
  return result;
}

/// A turn by an angle [rad], whose sine and cosine all points share.
struct Turn {
  double cosine;
  double sine;

  explicit Turn(double radians) : cosine(portable_cos(radians)), sine(portable_sin(radians)) {}
  PatchPoint of(const PatchPoint& point) const {
    return {cosine * point.u - sine * point.v, sine * point.u + cosine * point.v, point.d};
  }
};

}  // namespace

Image<float> turned(const Image<float>& square, int quarters) {
  assert(square.width() == square.height() && quarters >= 0);
  Image<float> result = square;
  for (int i = 0; i < quarters % 4; ++i) result = turned_once(result);
  return result;
}

PatchPoint turned(const PatchPoint& point, int quarters) {
  PatchPoint result = point;
  for (int i = 0; i < quarters % 4; ++i) result = {-result.v, result.u, result.d};
  return result;
}

Image<float> turned_by(const Image<float>& square, double radians, float background) {
  assert(square.width() == square.height());
  const int size = square.width();
  const double middle = 0.5 * (size - 1);
  const Turn back(-radians);
  Image<float> result(size, size, background);
  for (int v = 0; v < size; ++v) {
    for (int u = 0; u < size; ++u) {
      const PatchPoint from = back.of({u - middle, v - middle, 0.0});
      const double column = std::floor(from.u + middle + 0.5);
      const double row = std::floor(from.v + middle + 0.5);
      if (column < 0.0 || row < 0.0 || column >= size || row >= size) continue;
      result(u, v) = square(static_cast<int>(column), static_cast<int>(row));
    }
  }
  return result;
}

PatchPoint turned_by(const PatchPoint& point, double radians) {
  return Turn(radians).of(point);
}

}  // namespace knuckle
