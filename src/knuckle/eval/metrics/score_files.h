// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/eval/metrics/followed_hands.h"
#include "knuckle/eval/metrics/segmentation_metrics.h"

namespace knuckle {

/// The scores as JSON, motion from frame to frame included; a number that is not known is null. `in_common`:
/// the methods in the landmarks that all share, where there are such scores. `differences`: pairs of methods
/// (first, second, frames, mean_mm, interval_95_mm, p_value) that were compared in the same landmarks.
std::string to_json(const Evaluation& evaluation);

/// The same with what is known of segmentation, under `segmentation`: name, frames, missing, mean_iou,
/// median_iou and the part of frames with an overlap above 0.5 and 0.75 of each method; and of hands that
/// were followed, under `followed`: the numbers of FollowedScore. All parts may be missing.
std::string to_json(const std::optional<Evaluation>& evaluation, std::span<const SegmentationScore> boxes,
                    std::span<const FollowedScore> followed = {});

/// A field of a CSV file: in quotes where it holds a separator, quote or line end.
std::string csv_field(const std::string& text);

/// The overlap curves as CSV: method, threshold, frames_above.
std::string overlaps_csv(std::span<const SegmentationScore> boxes);

/// The curves as CSV: method, threshold_mm, frames_all_joints_within, frames_mean_within, joints_within.
std::string curves_csv(const Evaluation& evaluation);

/// The errors joint by joint as CSV: method, joint, frames, mean_3d_mm, median_3d_mm, mean_2d_px,
/// median_2d_px.
std::string joints_csv(const Evaluation& evaluation);

/// The errors frame by frame as CSV: method, frame (the first is 0), mean_3d_mm, largest_3d_mm; empty where
/// there is no truth or no complete prediction.
std::string frames_csv(const Evaluation& evaluation);

}  // namespace knuckle
