// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "knuckle/eval/evaluation.h"
#include "knuckle/eval/figures.h"
#include "knuckle/eval/segmentation_metrics.h"

namespace knuckle {

/// Curves over D of all methods: frames with all joints within D, with the mean within D, joints within D;
/// bars of the mean 3D and 2D error of each joint.
std::vector<Figure> figures_of(const Evaluation& evaluation);

// The three of them that are the rows of Riegler et al. 2015, fig. 5.
Figure all_joints_figure(const Evaluation& evaluation);
Figure joints_3d_figure(const Evaluation& evaluation);
Figure joints_2d_figure(const Evaluation& evaluation);

/// The fraction of frames with overlap r > t (Riegler et al. 2015, fig. 4).
Figure overlap_figure(std::span<const SegmentationScore> scores);

}  // namespace knuckle
