// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace knuckle {

/// How the cells of a square heat map lie over a patch: they part it evenly.
struct HeatMapGrid {
  int cells = 18;    ///< width and height of the map
  int size_px = 96;  ///< of the patch

  /// Column (or row) of the map -> u (or v) of the patch, and back. Cell 0 has its centre at 0.
  double coordinate_of(double cell) const;
  double cell_of(double coordinate) const;
};

/// The place of a map's peak [cells], and the largest value.
struct HeatMapPeak {
  double column = 0.0;
  double row = 0.0;
  float value = 0.0f;
};

/// The centre of the Gaussian that fits the values around the largest one best: least squares of the
/// logarithm, each weighted with the value's square (Guo 2011). Exact for a Gaussian, also at the border.
/// Where the values are no peak, or its centre would lie more than a cell off, it is the cell of the largest
/// value. `map`: cells x cells, row by row.
HeatMapPeak gaussian_peak(std::span<const float> map, int cells);

/// The mode of the positive values by mean shift with a Gaussian kernel, from the largest value on.
/// `bandwidth` above 0 [cells].
HeatMapPeak mean_shift_peak(std::span<const float> map, int cells, double bandwidth);

/// The mean bin number around the largest value, weighted with the positive values: the soft arg-max. It
/// looks equally far to both sides, at most 3 bins.
double soft_arg_max(std::span<const float> bins);

/// The depth of the surface that a cube patch shows at u, v: the median of 5 x 5 pixels, without those that
/// show no hand; of the smallest larger square that shows any where these do not; 0 where the patch shows
/// none. `patch`: size x size.
float surface_depth(std::span<const float> patch, int size, double u, double v);

}  // namespace knuckle
