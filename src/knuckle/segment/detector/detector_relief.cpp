// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_relief.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace knuckle {
namespace {

constexpr float kLeastProduct = 1e-6f;  // of inverse depths [1/m^2]: something 1 km away

struct Relief {
  int reach;      ///< of the square, on each side of the cell [cells]
  float unit_mm;  ///< is flattened to a half
};

constexpr std::array<Relief, kReliefInputs> kKinds = {{{3, 10.0f}, {12, 40.0f}}};

/// What is summed over a square: inverse depths, and how many of them were measured.
struct Sum {
  float inverse_depth = 0.0f;
  float count = 0.0f;

  void add(const Sum& other, float sign) {
    inverse_depth += sign * other.inverse_depth;
    count += sign * other.count;
  }
};

/// Sums over squares, one row after another: each column's sum over the rows in reach is kept, and moved.
class SquareSums {
 public:
  SquareSums(const DetectorOptions& options, std::span<const float> inverse_depth, int reach)
      : width_(options.width),
        height_(options.height),
        inverse_depth_(inverse_depth),
        reach_(reach),
        columns_(static_cast<std::size_t>(width_)) {
    for (int row = 0; row < std::min(reach_, height_); ++row) add_row(row, 1.0f);
  }

  /// Has to be called for rows 0, 1, 2 and so on.
  void move_to(int row) {
    if (row + reach_ < height_) add_row(row + reach_, 1.0f);
    if (row - reach_ - 1 >= 0) add_row(row - reach_ - 1, -1.0f);
  }

  /// Calls `use(column, sum)` for all columns of the row.
  template <class Use>
  void for_each_column(const Use& use) const {
    Sum sum;
    for (int column = 0; column < std::min(reach_, width_); ++column) sum.add(columns_[column], 1.0f);
    for (int column = 0; column < width_; ++column) {
      if (column + reach_ < width_) sum.add(columns_[column + reach_], 1.0f);
      if (column - reach_ - 1 >= 0) sum.add(columns_[column - reach_ - 1], -1.0f);
      use(column, sum);
    }
  }

 private:
  void add_row(int row, float sign) {
    const float* const from = inverse_depth_.data() + static_cast<std::size_t>(row) * width_;
    for (int column = 0; column < width_; ++column) {
      columns_[column].add({from[column], from[column] > 0.0f ? 1.0f : 0.0f}, sign);
    }
  }

  int width_;
  int height_;
  std::span<const float> inverse_depth_;
  int reach_;
  std::vector<Sum> columns_;
};

float flattened(float inverse, float mean, float unit_mm) {
  const float before_mm = 1000.0f * (inverse - mean) / std::max(mean * inverse, kLeastProduct);
  return before_mm / (unit_mm + std::abs(before_mm));
}

void write_relief(const DetectorOptions& options, std::span<const float> inverse_depth, const Relief& kind,
                  std::span<float> relief) {
  SquareSums sums(options, inverse_depth, kind.reach);
  for (int row = 0; row < options.height; ++row) {
    sums.move_to(row);
    const std::size_t first = static_cast<std::size_t>(row) * options.width;
    sums.for_each_column([&](int column, const Sum& sum) {
      const float inverse = inverse_depth[first + column];
      relief[first + column] =
          inverse > 0.0f ? flattened(inverse, sum.inverse_depth / sum.count, kind.unit_mm) : 0.0f;
    });
  }
}

}  // namespace

void write_reliefs(const DetectorOptions& options, std::span<const float> inverse_depth,
                   std::span<float> reliefs) {
  const std::size_t cells = inverse_depth.size();
  for (std::size_t i = 0; i < kKinds.size(); ++i) {
    write_relief(options, inverse_depth, kKinds[i], reliefs.subspan(i * cells, cells));
  }
}

}  // namespace knuckle
