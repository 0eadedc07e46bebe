// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "knuckle/experiment/layout.h"
#include "knuckle/experiment/plan.h"

namespace knuckle {

/// Scores all boxes and poses of an experiment and writes what is to be read of it: tables and timings as
/// CSV, figures as SVG and PNG, a page of details for each sequence, and last the page `report.html`, which
/// needs no other file. `sources` has one per sequence.
void write_experiment_report(const ExperimentPlan& plan, std::span<const std::string> sources, double scale,
                             const ExperimentFolder& folder);

}  // namespace knuckle
