// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/eval/metrics/followed_hands.h"
#include "knuckle/eval/metrics/segmentation_metrics.h"
#include "knuckle/eval/pictures/figures.h"

namespace knuckle {

/// Curves over D of all methods: frames with all joints within D, with the mean within D, joints within D;
/// bars of the mean 3D and 2D error of each joint.
std::vector<Figure> figures_of(const Evaluation& evaluation);

/// The part of the frames all of whose joints lie within D: the third row of Riegler et al. 2015, fig. 5.
Figure all_joints_figure(const Evaluation& evaluation);
/// Mean 3D error a joint [mm]: its second row.
Figure joints_3d_figure(const Evaluation& evaluation);
/// Mean 2D error a joint [px]: its first row.
Figure joints_2d_figure(const Evaluation& evaluation);

/// The fraction of frames with overlap r > t (Riegler et al. 2015, fig. 4).
Figure overlap_figure(std::span<const SegmentationScore> scores);

/// The share of joints within kReliableMm over their confidence, a curve per method that gives confidences,
/// and the diagonal that calibrated ones lie on. Tenths with fewer than 20 joints are left out.
Figure reliability_figure(std::span<const FollowedScore> scores);

}  // namespace knuckle
