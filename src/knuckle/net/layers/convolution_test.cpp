// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/convolution.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

std::vector<float> random_numbers(std::size_t count, std::uint64_t stream) {
  Random random(7, stream);
  std::vector<float> numbers(count);
  for (float& number : numbers) number = static_cast<float>(random.uniform(-1.0, 1.0));
  return numbers;
}

struct Case {
  std::string name;
  Convolution::Shape shape;
  int size;
};

class Convolutions : public ::testing::TestWithParam<Case> {
 protected:
  FeatureMap input_map(int border) const {
    const auto& [name, shape, size] = GetParam();
    FeatureMap map = shape.inputs == 1 ? FeatureMap::of_image(size, border)
                                       : FeatureMap({size, size, shape.inputs, border});
    Random random(3);
    for (int row = 0; row < size; ++row) {
      for (int column = 0; column < size; ++column) {
        for (int i = 0; i < shape.inputs; ++i) {
          map.pixel(row, column)[i] = static_cast<float>(random.uniform(-1.0, 1.0));
        }
      }
    }
    return map;
  }

  /// By the definition, in double precision.
  double reference(const FeatureMap& input, int output, int row, int column) const {
    const auto& [name, shape, size] = GetParam();
    double sum = bias_[output];
    for (int i = 0; i < shape.inputs; ++i) {
      for (int y = 0; y < shape.kernel; ++y) {
        for (int x = 0; x < shape.kernel; ++x) {
          const int from_row = row * shape.stride - shape.padding + y;
          const int from_column = column * shape.stride - shape.padding + x;
          const bool is_inside = from_row >= 0 && from_row < size && from_column >= 0 && from_column < size;
          if (!is_inside) continue;
          const float weight = weights_[((output * shape.inputs + i) * shape.kernel + y) * shape.kernel + x];
          sum += static_cast<double>(weight) * input.pixel(from_row, from_column)[i];
        }
      }
    }
    return sum;
  }

  std::size_t weight_count() const {
    const Convolution::Shape& shape = GetParam().shape;
    return static_cast<std::size_t>(shape.outputs) * shape.inputs * shape.kernel * shape.kernel;
  }

  std::vector<float> weights_ = random_numbers(weight_count(), 1);
  std::vector<float> bias_ = random_numbers(static_cast<std::size_t>(GetParam().shape.outputs), 2);
};

INSTANTIATE_TEST_SUITE_P(
    , Convolutions,
    ::testing::Values(
        // Of `dense`, on smaller maps.
        Case{"stem", {1, 16, 5, 2, 2}, 32}, Case{"down1", {16, 32, 3, 2, 1}, 16},
        Case{"block", {32, 32, 3, 1, 1}, 12}, Case{"block3", {128, 128, 3, 1, 1}, 6},
        Case{"lateral", {128, 64, 1, 1, 0}, 6}, Case{"head", {64, 110, 1, 1, 0}, 8},
        // Of the banks.
        Case{"bank5", {1, 16, 5, 1, 0}, 24}, Case{"bank6", {16, 32, 6, 1, 0}, 23},
        Case{"bank5_of_16", {16, 32, 5, 1, 0}, 22}, Case{"bank4", {1, 16, 4, 1, 0}, 24},
        Case{"bank4_of_16", {16, 32, 4, 1, 0}, 21},
        // Odd ones: channels that fill no register, widths of all remainders, larger padding and stride.
        Case{"a_single_pixel", {3, 5, 3, 1, 1}, 1}, Case{"two_pixels", {3, 9, 3, 1, 1}, 2},
        Case{"three_pixels", {9, 17, 3, 1, 1}, 3}, Case{"four_pixels", {7, 24, 1, 1, 0}, 4},
        Case{"eleven_pixels", {2, 23, 2, 1, 0}, 12}, Case{"stride3", {5, 8, 3, 3, 1}, 14},
        // By tiles (16 inputs and more): maps that they do not divide, fewer outputs than a register has,
        // more tiles than are worked on together, and channels of which Tile4 or Tile2 is chosen.
        Case{"tile_of_one_pixel", {16, 5, 3, 1, 1}, 1}, Case{"tile_of_two", {17, 24, 3, 1, 1}, 2},
        Case{"tile_of_three", {20, 33, 3, 1, 1}, 3}, Case{"tiles_of_five", {16, 16, 3, 1, 1}, 5},
        Case{"tiles_of_six", {24, 40, 3, 1, 1}, 6}, Case{"many_tiles", {16, 16, 3, 1, 1}, 43},
        Case{"small_tiles", {126, 100, 3, 1, 1}, 7}, Case{"many_small_tiles", {120, 101, 3, 1, 1}, 15},
        Case{"wide_padding", {2, 3, 5, 2, 4}, 7}, Case{"one_output", {4, 1, 3, 1, 1}, 7}),
    [](const auto& instance) { return instance.param.name; });

TEST_P(Convolutions, AreTheDefinitions) {
  const Convolution::Shape& shape = GetParam().shape;
  const FeatureMap input = input_map(shape.padding);
  const Convolution convolution(shape, input.pixel_stride(), weights_, bias_);
  const int size = convolution.output_size(GetParam().size);
  FeatureMap linear({size, size, shape.outputs, 1});
  FeatureMap rectified({size, size, shape.outputs});
  FeatureMap added({size, size, shape.outputs, 2});
  for (int row = 0; row < size; ++row) {
    for (int o = 0; o < shape.outputs; ++o) added.pixel(row, size - 1)[o] = static_cast<float>(row - o);
  }
  FeatureMap sum = added;
  convolution.apply(input, linear, Activation::linear);
  convolution.apply(input, rectified, Activation::relu);
  convolution.apply(input, sum, Activation::relu, &sum);
  const double tolerance = 1e-5 * std::sqrt(static_cast<double>(weight_count()) / shape.outputs) + 1e-6;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      for (int o = 0; o < shape.outputs; ++o) {
        const double expected = reference(input, o, row, column);
        ASSERT_NEAR(linear.pixel(row, column)[o], expected, tolerance) << row << ", " << column << ", " << o;
        ASSERT_NEAR(rectified.pixel(row, column)[o], std::max(expected, 0.0), tolerance);
        const double with_added = expected + added.pixel(row, column)[o];
        ASSERT_NEAR(sum.pixel(row, column)[o], std::max(with_added, 0.0), tolerance * 10);
      }
    }
  }
}

TEST_P(Convolutions, RoundLittle) {
  const Convolution::Shape& shape = GetParam().shape;
  const FeatureMap input = input_map(shape.padding);
  const Convolution convolution(shape, input.pixel_stride(), weights_, bias_);
  const int size = convolution.output_size(GetParam().size);
  FeatureMap output({size, size, shape.outputs, 1});
  convolution.apply(input, output, Activation::linear);
  double squares = 0.0;
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      for (int o = 0; o < shape.outputs; ++o) {
        const double error = output.pixel(row, column)[o] - reference(input, o, row, column);
        squares += error * error;
      }
    }
  }
  const double error = std::sqrt(squares / (size * size * shape.outputs));
  const double terms = static_cast<double>(weight_count()) / shape.outputs;
  // By the definition half of that at most; by tiles with the points of the paper, twice that.
  EXPECT_LT(error, 0x1p-26 * terms);
}

TEST_P(Convolutions, LeaveTheBorderAndTheSpareChannelsZero) {
  const Convolution::Shape& shape = GetParam().shape;
  const FeatureMap input = input_map(shape.padding);
  const Convolution convolution(shape, input.pixel_stride(), weights_, bias_);
  const int size = convolution.output_size(GetParam().size);
  FeatureMap output({size, size, shape.outputs, 1});
  convolution.apply(input, output, Activation::linear);
  for (int row = -1; row <= size; ++row) {
    for (int column = -1; column <= size; ++column) {
      const bool is_inside = row >= 0 && row < size && column >= 0 && column < size;
      for (int o = is_inside ? shape.outputs : 0; o < output.pixel_stride(); ++o) {
        ASSERT_EQ(output.pixel(row, column)[o], 0.0f) << row << ", " << column << ", " << o;
      }
    }
  }
}

}  // namespace
}  // namespace knuckle
