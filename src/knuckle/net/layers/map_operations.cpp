// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/map_operations.h"

#include <algorithm>

namespace knuckle {

void copy_image(const Image<float>& image, FeatureMap& map) {
  for (int row = 0; row < image.height(); ++row) std::ranges::copy(image.row(row), map.pixel(row, 0));
}

void add_twice_as_large(const FeatureMap& coarse, FeatureMap& fine) {
  const int numbers = fine.pixel_stride();
  for (int row = 0; row < fine.height(); ++row) {
    for (int column = 0; column < fine.width(); ++column) {
      const float* const from = coarse.pixel(row / 2, column / 2);
      float* const to = fine.pixel(row, column);
      for (int i = 0; i < numbers; ++i) to[i] += from[i];
    }
  }
}

void max_pool(const FeatureMap& input, int size, FeatureMap& output) {
  const int numbers = output.pixel_stride();
  for (int row = 0; row < output.height(); ++row) {
    for (int column = 0; column < output.width(); ++column) {
      float* const to = output.pixel(row, column);
      std::copy_n(input.pixel(row * size, column * size), numbers, to);
      for (int k = 1; k < size * size; ++k) {
        const float* const from = input.pixel(row * size + k / size, column * size + k % size);
        for (int i = 0; i < numbers; ++i) to[i] = std::max(to[i], from[i]);
      }
    }
  }
}

void halve(const FeatureMap& input, FeatureMap& output) {
  const int numbers = output.pixel_stride();
  for (int row = 0; row < output.height(); ++row) {
    for (int column = 0; column < output.width(); ++column) {
      const float* const upper = input.pixel(2 * row, 2 * column);
      const float* const lower = input.pixel(2 * row + 1, 2 * column);
      float* const to = output.pixel(row, column);
      for (int i = 0; i < numbers; ++i) {
        to[i] = 0.25f * (upper[i] + upper[i + numbers] + lower[i] + lower[i + numbers]);
      }
    }
  }
}

}  // namespace knuckle
