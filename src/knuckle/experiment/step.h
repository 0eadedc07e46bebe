// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>

#include "knuckle/prepare/inputs.h"

namespace knuckle {

/// What the work of a step finds.
enum class StepStart {
  anew,   ///< whatever lies there is of other inputs
  again,  ///< a run with the same inputs was stopped: what it left may be used
};

/// What became of a step.
enum class StepOutcome {
  done,  ///< the work was done
  kept,  ///< the output was there, made from the same inputs
};

/// Whether `output` is there, made from these inputs.
bool is_step_done(const std::filesystem::path& output, const Inputs& inputs);

/// Does `work`, which writes `output` (whole or not at all), unless that was made from the same inputs
/// before. The inputs are kept beside it, as `OUTPUT.begun` while the work is done and as `OUTPUT.inputs`
/// after it, so that a run that was stopped or changed redoes only what it must. Of several processes that
/// come to a step at the same time one does it (`OUTPUT.claim`), and the others wait for it.
StepOutcome run_step(const std::filesystem::path& output, const Inputs& inputs,
                     const std::function<void(StepStart)>& work);

}  // namespace knuckle
