// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace knuckle {

/// What an experiment takes from the summary that `knuckle segment --json` writes.
struct SegmentationSummary {
  double median_ms = 0.0;  ///< of a frame
  double mask_iou = 0.0;   ///< of all pixels with the true masks, NaN where there are none
};

/// Throws an Error that names the file where it is missing, or not such a summary.
SegmentationSummary read_segmentation_summary(const std::filesystem::path& path);

/// Median time of crop, inference and refinement of a frame [ms], from the summary that `knuckle estimate
/// --json` writes. Throws as `read_segmentation_summary`.
double read_inference_ms(const std::filesystem::path& path);

}  // namespace knuckle
