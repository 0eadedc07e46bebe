// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/heat_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>

#include "knuckle/core/statistics.h"
#include "knuckle/patch/cube_patch.h"

namespace knuckle {
namespace {

constexpr int kFitRadius = 2;            // cells around the largest that a Gaussian is fitted to
constexpr double kSmallestPart = 0.02;   // of the largest: smaller values are not fitted
constexpr double kFarthestCentre = 1.0;  // from the largest cell [cells]
constexpr int kMostShifts = 100;
constexpr double kShiftEnd = 1e-4;  // [cells]
constexpr int kBinRadius = 3;
constexpr int kSurfaceRadius = 2;  // pixels whose median is the surface's depth

struct Cell {
  int column;
  int row;
};

Cell largest_cell(std::span<const float> map, int cells) {
  const auto place = static_cast<int>(std::ranges::max_element(map) - map.begin());
  return {place % cells, place / cells};
}

/// Calls `visit(column, row)` for the cells at most `radius` from `centre`.
template <class Visit>
void for_cells_around(const Cell& centre, int radius, int cells, const Visit& visit) {
  for (int row = std::max(centre.row - radius, 0); row <= std::min(centre.row + radius, cells - 1); ++row) {
    const int end = std::min(centre.column + radius, cells - 1);
    for (int column = std::max(centre.column - radius, 0); column <= end; ++column) visit(column, row);
  }
}

}  // namespace

double HeatMapGrid::coordinate_of(double cell) const {
  const double px = (cell + 0.5) * size_px / cells - 0.5;
  return 2.0 * px / (size_px - 1) - 1.0;
}

double HeatMapGrid::cell_of(double coordinate) const {
  const double px = 0.5 * (coordinate + 1.0) * (size_px - 1);
  return (px + 0.5) * cells / size_px - 0.5;
}

HeatMapPeak gaussian_peak(std::span<const float> map, int cells) {
  const Cell top = largest_cell(map, cells);
  const auto value = [&](int column, int row) { return static_cast<double>(map[row * cells + column]); };
  const double largest = value(top.column, top.row);
  const HeatMapPeak at_cell{double(top.column), double(top.row), static_cast<float>(largest)};
  if (!(largest > 0.0)) return at_cell;
  // ln value = a + b x + c y + e (x^2 + y^2), with x and y from the largest cell.
  Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
  Eigen::Vector4d sums = Eigen::Vector4d::Zero();
  int count = 0;
  for_cells_around(top, kFitRadius, cells, [&](int column, int row) {
    const double part = value(column, row) / largest;
    if (part < kSmallestPart) return;
    const double x = column - top.column;
    const double y = row - top.row;
    const Eigen::Vector4d terms(1.0, x, y, x * x + y * y);
    products += part * part * terms * terms.transpose();
    sums += part * part * std::log(part) * terms;
    ++count;
  });
  if (count < 5) return at_cell;  // four unknowns, and a value to spare
  const Eigen::Vector4d fit = products.ldlt().solve(sums);
  const double x = -0.5 * fit[1] / fit[3];
  const double y = -0.5 * fit[2] / fit[3];
  const bool is_peak = fit[3] < 0.0 && std::abs(x) <= kFarthestCentre && std::abs(y) <= kFarthestCentre;
  return is_peak ? HeatMapPeak{top.column + x, top.row + y, at_cell.value} : at_cell;
}

HeatMapPeak mean_shift_peak(std::span<const float> map, int cells, double bandwidth) {
  const Cell top = largest_cell(map, cells);
  HeatMapPeak peak{double(top.column), double(top.row), map[top.row * cells + top.column]};
  for (int shift = 0; shift < kMostShifts; ++shift) {
    double weights = 0.0;
    double columns = 0.0;
    double rows = 0.0;
    for_cells_around(top, cells, cells, [&](int column, int row) {
      const double x = column - peak.column;
      const double y = row - peak.row;
      const double kernel = std::exp(-0.5 * (x * x + y * y) / (bandwidth * bandwidth));
      const double weight = kernel * std::max(map[row * cells + column], 0.0f);
      weights += weight;
      columns += weight * column;
      rows += weight * row;
    });
    if (!(weights > 0.0)) break;
    const double moved = std::hypot(columns / weights - peak.column, rows / weights - peak.row);
    peak.column = columns / weights;
    peak.row = rows / weights;
    if (moved < kShiftEnd) break;
  }
  return peak;
}

double soft_arg_max(std::span<const float> bins) {
  const auto top = static_cast<int>(std::ranges::max_element(bins) - bins.begin());
  const int last = static_cast<int>(bins.size()) - 1;
  const int radius = std::min({kBinRadius, top, last - top});
  double weights = 0.0;
  double sum = 0.0;
  for (int i = top - radius; i <= top + radius; ++i) {
    const double weight = std::max(bins[i], 0.0f);
    weights += weight;
    sum += weight * i;
  }
  return weights > 0.0 ? sum / weights : top;
}

float surface_depth(std::span<const float> patch, int size, double u, double v) {
  const double half = 0.5 * (size - 1);
  const auto pixel_of = [&](double at) {
    return static_cast<int>(std::lround(std::clamp(half * (at + 1.0), 0.0, 2.0 * half)));
  };
  const Cell centre{pixel_of(u), pixel_of(v)};
  std::vector<float> depths;
  for (int radius = kSurfaceRadius; depths.empty() && radius < size; ++radius) {
    for_cells_around(centre, radius, size, [&](int column, int row) {
      const float depth = patch[row * size + column];
      if (depth < kCubeBackground) depths.push_back(depth);
    });
  }
  if (depths.empty()) return 0.0f;
  return upper_median(std::span(depths));
}

}  // namespace knuckle
