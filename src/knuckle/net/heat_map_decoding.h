// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "knuckle/net/network_inference.h"

namespace knuckle {

/// How far `heatmap2d` puts a joint behind the surface: the best of 0, 8, 12 and 16 mm on validation frames.
inline constexpr double kJointBehindSkinMm = 12.0;

/// The joints of an output of `heatmap2d` (`kJointBehindSkinMm` behind the surface that the patch shows
/// there) or `heatmap25d`; the confidence of a joint is the height of its map's peak, cut to [0, 1].
///
/// `output`: the cells of all joints' maps, then the bins of all joints. `patch`: size_px x size_px.
NetworkPrediction decode_heat_maps(const NetworkOptions& options, std::span<const float> output,
                                   std::span<const float> patch);

}  // namespace knuckle
