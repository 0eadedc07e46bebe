// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/eval/evaluation.h"

namespace knuckle {

/// The scores as JSON (the keys of DESIGN.md, section 4); a number that is not known is null.
std::string to_json(const Evaluation& evaluation);

/// The curves as CSV: method, threshold_mm, frames_all_joints_within, frames_mean_within, joints_within.
std::string curves_csv(const Evaluation& evaluation);

/// The errors joint by joint as CSV: method, joint, frames, mean_3d_mm, median_3d_mm, mean_2d_px,
/// median_2d_px.
std::string joints_csv(const Evaluation& evaluation);

}  // namespace knuckle
