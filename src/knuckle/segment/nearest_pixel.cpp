// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/nearest_pixel.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "knuckle/core/box.h"
#include "knuckle/core/frame.h"

namespace knuckle {
namespace {

constexpr int kRadius = 2;           // of the 5x5 window
constexpr int kFewestMeasured = 13;  // more than half of the window
// A median of at least kFewestMeasured values is below a bound only where at least this many of them are.
constexpr int kFewestCloser = (kFewestMeasured + 1) / 2;
constexpr int kFewCandidates = 64;  // of a row: they are looked at one by one
constexpr int kGridStep = 12;       // of the coarse search for a first bound [px]

Box window_of(const Image<float>& image, int column, int row) {
  return intersection(Box{column - kRadius, row - kRadius, 2 * kRadius + 1, 2 * kRadius + 1},
                      Box{0, 0, image.width(), image.height()});
}

/// Whether the median of the window is below `bound`, found by counting.
bool median_is_below(const Image<float>& depth_mm, int column, int row, float bound) {
  const Box window = window_of(depth_mm, column, row);
  int measured = 0;
  int closer = 0;
  for (int j = window.y; j < window.bottom(); ++j) {
    const float* const line = depth_mm.row(j).data();
    for (int i = window.x; i < window.right(); ++i) {
      measured += is_measured(line[i]) ? 1 : 0;
      closer += (line[i] > 0.0f && line[i] < bound) ? 1 : 0;
    }
  }
  return measured >= kFewestMeasured && 2 * closer >= measured;
}

/// Lowers `best` where the median at this pixel is below it.
void improve(NearestPixel& best, const Image<float>& depth_mm, int column, int row) {
  if (!median_is_below(depth_mm, column, row, best.depth_mm)) return;
  best = NearestPixel{column, row, median_depth(depth_mm, column, row)};
}

/// For each pixel, how many of the five around it in its row are closer than `bound`.
Image<std::uint8_t> closer_in_row(const Image<float>& depth_mm, float bound) {
  const int width = depth_mm.width();
  Image<std::uint8_t> sums(width, depth_mm.height());
  std::vector<std::uint8_t> closer(static_cast<std::size_t>(width) + 2 * kRadius);
  for (int row = 0; row < depth_mm.height(); ++row) {
    const float* const depth = depth_mm.row(row).data();
    std::uint8_t* const flag = closer.data() + kRadius;
    for (int i = 0; i < width; ++i) {
      flag[i] =
          static_cast<std::uint8_t>(static_cast<int>(depth[i] > 0.0f) & static_cast<int>(depth[i] < bound));
    }
    std::uint8_t* const sum = sums.row(row).data();
    for (int i = 0; i < width; ++i) {
      sum[i] = static_cast<std::uint8_t>(flag[i - 2] + flag[i - 1] + flag[i] + flag[i + 1] + flag[i + 2]);
    }
  }
  return sums;
}

/// Keeps those candidates of a row whose window's median is below the bound: at least half of what was
/// measured is. The others get 0. Pays where there are many.
void keep_those_below(const Image<float>& depth_mm, int row, std::vector<std::uint8_t>& candidates) {
  const int width = depth_mm.width();
  std::vector<std::uint8_t> in_column(static_cast<std::size_t>(width) + 2 * kRadius);
  std::uint8_t* const measured = in_column.data() + kRadius;
  for (int j = std::max(row - kRadius, 0); j <= std::min(row + kRadius, depth_mm.height() - 1); ++j) {
    const float* const depth = depth_mm.row(j).data();
    for (int i = 0; i < width; ++i)
      measured[i] = static_cast<std::uint8_t>(measured[i] + is_measured(depth[i]));
  }
  for (int i = 0; i < width; ++i) {
    const int in_window = measured[i - 2] + measured[i - 1] + measured[i] + measured[i + 1] + measured[i + 2];
    const bool is_below = (in_window >= kFewestMeasured) & (2 * candidates[i] >= in_window);
    candidates[i] = is_below ? candidates[i] : std::uint8_t{0};
  }
}

/// For each column of `row` how many of its window are below the bound that `sums` were made with. Whether in
/// one of them a median may be.
bool mark_candidates(const Image<std::uint8_t>& sums, int row, std::vector<std::uint8_t>& candidates) {
  const int width = sums.width();
  std::ranges::fill(candidates, std::uint8_t{0});
  for (int j = std::max(row - kRadius, 0); j <= std::min(row + kRadius, sums.height() - 1); ++j) {
    const std::uint8_t* const sum = sums.row(j).data();
    for (int i = 0; i < width; ++i) candidates[i] = static_cast<std::uint8_t>(candidates[i] + sum[i]);
  }
  std::uint8_t most = 0;
  for (int i = 0; i < width; ++i) most = std::max(most, candidates[i]);
  return most >= kFewestCloser;
}

}  // namespace

float median_depth(const Image<float>& depth_mm, int column, int row) {
  const Box window = window_of(depth_mm, column, row);
  std::array<float, 25> values;
  int count = 0;
  for (int j = window.y; j < window.bottom(); ++j) {
    for (int i = window.x; i < window.right(); ++i) {
      if (is_measured(depth_mm(i, j))) values[count++] = depth_mm(i, j);
    }
  }
  if (count < kFewestMeasured) return 0.0f;
  const auto middle = values.begin() + (count - 1) / 2;
  std::nth_element(values.begin(), middle, values.begin() + count);
  return *middle;
}

std::optional<NearestPixel> nearest_pixel(const Image<float>& depth_mm) {
  NearestPixel best{-1, -1, std::numeric_limits<float>::infinity()};
  // A coarse grid gives a bound that few pixels lie below; only those are looked at one by one.
  for (int row = 0; row < depth_mm.height(); row += kGridStep) {
    for (int column = 0; column < depth_mm.width(); column += kGridStep) improve(best, depth_mm, column, row);
  }
  const Image<std::uint8_t> sums = closer_in_row(depth_mm, best.depth_mm);
  std::vector<std::uint8_t> candidates(static_cast<std::size_t>(depth_mm.width()));
  for (int row = 0; row < depth_mm.height(); ++row) {
    if (!mark_candidates(sums, row, candidates)) continue;
    const auto is_candidate = [](std::uint8_t closer) { return closer >= kFewestCloser; };
    if (std::ranges::count_if(candidates, is_candidate) > kFewCandidates)
      keep_those_below(depth_mm, row, candidates);
    for (int column = 0; column < depth_mm.width(); ++column) {
      if (candidates[column] >= kFewestCloser) improve(best, depth_mm, column, row);
    }
  }
  return best.column < 0 ? std::nullopt : std::optional(best);
}

}  // namespace knuckle
