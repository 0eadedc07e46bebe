// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/search_image.h"

#include <cstddef>
#include <cstdint>
#include <limits>

namespace knuckle {

int search_stride(const Image<float>& depth_mm, int most) {
  if (depth_mm.size() <= static_cast<std::size_t>(most)) return 1;
  std::int64_t measured = 0;
  for (int row = 0; row < depth_mm.height(); ++row) {
    int in_row = 0;
    for (const float depth : depth_mm.row(row)) {
      in_row += static_cast<int>(depth > 0.0f) & static_cast<int>(depth <= std::numeric_limits<float>::max());
    }
    measured += in_row;
  }
  int stride = 1;
  while (measured > std::int64_t{most} * stride * stride) ++stride;
  return stride;
}

Image<float> thinned(const Image<float>& depth_mm, int stride) {
  Image<float> result((depth_mm.width() + stride - 1) / stride, (depth_mm.height() + stride - 1) / stride);
  for (int row = 0; row < result.height(); ++row) {
    const float* const from = depth_mm.row(row * stride).data();
    float* const to = result.row(row).data();
    for (int column = 0; column < result.width(); ++column) to[column] = from[column * stride];
  }
  return result;
}

Camera thinned(Camera camera, int stride) {
  camera.width = (camera.width + stride - 1) / stride;
  camera.height = (camera.height + stride - 1) / stride;
  camera.fx /= stride;
  camera.fy /= stride;
  camera.cx /= stride;
  camera.cy /= stride;
  return camera;
}

}  // namespace knuckle
