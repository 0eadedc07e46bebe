// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "knuckle/pipeline/estimate_each.h"

namespace knuckle {

/// Runs the pipeline on all frames of a source on all threads, shows progress, and keeps all results (without
/// masks): for sources of some thousand frames; `estimate_each` serves any number. Throws an Error that names
/// the source where it has no truth to start from, and the fault of the first frame that cannot be read.
std::vector<FrameEstimate> estimate_all(const FrameSource& source, const Pipeline& pipeline, Start start,
                                        std::string_view source_name);

/// The poses of the `rank`-th surest hand of each frame (0 is the surest); missing where a frame has fewer.
std::vector<HandPose> poses_of(std::span<const FrameEstimate> frames, const Convention& convention,
                               int rank = 0);

/// The pose of the `rank`-th surest hand of a frame; missing where it has fewer.
HandPose pose_of(const FrameEstimate& frame, const Convention& convention, int rank = 0);

/// The median time that the pipeline took for a frame [ms], to 0.1 per cent.
double median_ms(std::span<const FrameEstimate> frames);

}  // namespace knuckle
