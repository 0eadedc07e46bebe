// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "knuckle/experiment/plan.h"

namespace knuckle {

/// Where an experiment in the folder `out` keeps what a method made of a sequence.
std::filesystem::path boxes_file(const std::filesystem::path& out, const PlannedSequence& sequence,
                                 const PlannedMethod& method);
/// The same for poses.
std::filesystem::path poses_file(const std::filesystem::path& out, const PlannedSequence& sequence,
                                 const PlannedMethod& method);
/// Counts and times, beside such a file.
std::filesystem::path summary_file(std::filesystem::path result);

/// Scores all boxes and poses of an experiment and writes `out / report.html`: an overview, then for each
/// sequence the paper's Figure 4 (boxes with r > t) and Figure 5 (errors of the joints). `sources` has one a
/// sequence.
void write_experiment_report(const ExperimentPlan& plan, std::span<const std::string> sources,
                             const std::filesystem::path& out);

}  // namespace knuckle
