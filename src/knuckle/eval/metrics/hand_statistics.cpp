// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/hand_statistics.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>

#include "knuckle/core/frame.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr float kSmoothMm = 15.0f;   ///< neighbours on one surface differ by at most this
constexpr float kJumpMm = 30.0f;     ///< surfaces on both sides of a depth edge differ by more than this
constexpr float kHangingMm = 10.0f;  ///< a flying pixel is farther than this from both
constexpr int kOutlineReachPx = 3;   ///< an outline moves at most this much from row to row

/// A hand in its frame, in the frame's coordinates.
struct Hand {
  const Image<float>& depth_mm;
  const Box& box;
  const Image<std::uint8_t>& mask;

  bool is_hand(int column, int row) const {
    return box.contains(column, row) && mask(column - box.x, row - box.y) != 0;
  }
  float depth(int column, int row) const {
    return depth_mm.contains(column, row) ? depth_mm(column, row) : 0.0f;
  }
};

template <class Visit>
void for_each_pixel(const Box& box, const Visit& visit) {
  for (int row = box.y; row < box.bottom(); ++row) {
    for (int column = box.x; column < box.right(); ++column) visit(column, row);
  }
}

void measure_depths(const Hand& hand, HandStatistics& statistics) {
  RunningMean depth;
  RunningMean square;
  RunningMean valid;
  for_each_pixel(hand.box, [&](int column, int row) {
    const float here = hand.depth(column, row);
    valid.add(is_measured(here) ? 1.0 : 0.0);
    if (!hand.is_hand(column, row)) return;
    depth.add(here);
    square.add(double{here} * here);
  });
  statistics.depth_mm = depth.value();
  statistics.depth_spread_mm = std::sqrt(std::max(square.value() - depth.value() * depth.value(), 0.0));
  statistics.valid_share = valid.value();
}

double surface_noise_mm(const Hand& hand) {
  RunningMean size;
  for_each_pixel(hand.box, [&](int column, int row) {
    for (const auto& [x, y] : {std::pair{1, 0}, {0, 1}}) {
      if (!hand.is_hand(column, row) || !hand.is_hand(column - x, row - y) ||
          !hand.is_hand(column + x, row + y)) {
        continue;
      }
      const float before = hand.depth(column, row) - hand.depth(column - x, row - y);
      const float after = hand.depth(column + x, row + y) - hand.depth(column, row);
      if (std::abs(before) <= kSmoothMm && std::abs(after) <= kSmoothMm) size.add(std::abs(after - before));
    }
  });
  return size.value() / std::sqrt(12.0 / std::numbers::pi);
}

/// Whether the hand starts (or ends, for `side` 1) at this column, seen along the row.
bool is_outline(const Hand& hand, int column, int row, int side) {
  return hand.is_hand(column, row) && !hand.is_hand(column + (side == 0 ? -1 : 1), row);
}

/// Where the outline that is at `column` in the row beside passes `row`.
std::optional<int> outline_near(const Hand& hand, int column, int row, int side) {
  for (int reach = 0; reach <= kOutlineReachPx; ++reach) {
    if (is_outline(hand, column - reach, row, side)) return column - reach;
    if (is_outline(hand, column + reach, row, side)) return column + reach;
  }
  return std::nullopt;
}

double edge_noise_px(const Hand& hand) {
  RunningMean square;
  for_each_pixel(hand.box, [&](int column, int row) {
    for (int side = 0; side < 2; ++side) {
      if (!is_outline(hand, column, row, side)) continue;
      const auto above = outline_near(hand, column, row - 1, side);
      const auto below = outline_near(hand, column, row + 1, side);
      if (!above || !below) continue;
      const double residual = column - 0.5 * (*above + *below);
      square.add(residual * residual);
    }
  });
  return std::sqrt(square.value() / 1.5);
}

double flying_share(const Hand& hand) {
  RunningMean flying;
  for_each_pixel(hand.box, [&](int column, int row) {
    const float here = hand.depth(column, row);
    for (const auto& [x, y] : {std::pair{1, 0}, {0, 1}}) {
      const float one = hand.depth(column - x, row - y);
      const float other = hand.depth(column + x, row + y);
      if (here == 0.0f || one == 0.0f || other == 0.0f || std::abs(one - other) <= kJumpMm) continue;
      const bool hangs = std::abs(here - one) > kHangingMm && std::abs(here - other) > kHangingMm;
      const bool is_between = (here - one) * (other - here) > 0.0f;
      flying.add(hangs && is_between ? 1.0 : 0.0);
    }
  });
  return flying.value();
}

constexpr std::array kValues = {&HandStatistics::depth_mm,      &HandStatistics::depth_spread_mm,
                                &HandStatistics::valid_share,   &HandStatistics::surface_noise_mm,
                                &HandStatistics::edge_noise_px, &HandStatistics::flying_share};

}  // namespace

HandStatistics hand_statistics(const Image<float>& depth_mm, const Box& box,
                               const Image<std::uint8_t>& mask) {
  const Hand hand{depth_mm, box, mask};
  HandStatistics statistics;
  measure_depths(hand, statistics);
  statistics.surface_noise_mm = surface_noise_mm(hand);
  statistics.edge_noise_px = edge_noise_px(hand);
  statistics.flying_share = flying_share(hand);
  return statistics;
}

HandStatistics mean_of(std::span<const HandStatistics> frames) {
  HandStatistics result;
  for (const auto value : kValues) {
    RunningMean mean;
    for (const HandStatistics& frame : frames) {
      if (std::isfinite(frame.*value)) mean.add(frame.*value);
    }
    result.*value = mean.value();
  }
  return result;
}

}  // namespace knuckle
