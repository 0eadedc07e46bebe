// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/heat_map_decoding.h"

#include <algorithm>

#include "knuckle/net/heat_map.h"
#include "knuckle/net/paper_architecture.h"

namespace knuckle {
namespace {

HeatMapPeak peak_of(std::span<const float> map, const PaperNetworkOptions& options) {
  return options.peak == "gaussian" ? gaussian_peak(map, options.map_cells)
                                    : mean_shift_peak(map, options.map_cells, options.peak_deviation);
}

}  // namespace

NetworkPrediction decode_heat_maps(const NetworkOptions& options, std::span<const float> output,
                                   std::span<const float> patch) {
  const HeatMapGrid grid{options.paper.map_cells, options.patch.size_px};
  const auto cells = static_cast<std::size_t>(grid.cells) * grid.cells;
  const auto bins = static_cast<std::size_t>(depth_bins_per_joint(options));
  const auto joints = static_cast<std::size_t>(options.joint_count());
  NetworkPrediction prediction;
  for (std::size_t j = 0; j < joints; ++j) {
    const HeatMapPeak peak = peak_of(output.subspan(j * cells, cells), options.paper);
    const double u = grid.coordinate_of(peak.column);
    const double v = grid.coordinate_of(peak.row);
    double d = 0.0;
    if (bins > 0) {
      const double bin = soft_arg_max(output.subspan(joints * cells + j * bins, bins));
      d = 2.0 * (bin + 0.5) / static_cast<double>(bins) - 1.0;
    } else {
      d = surface_depth(patch, grid.size_px, u, v) + kJointBehindSkinMm / (0.5 * options.patch.cube_mm);
    }
    prediction.joints.push_back({u, v, d});
    prediction.confidence.push_back(std::clamp(peak.value, 0.0f, 1.0f));
  }
  return prediction;
}

}  // namespace knuckle
