// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/turned_patch.h"

#include <cassert>

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

}  // namespace knuckle
