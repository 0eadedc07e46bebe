// SPDX-License-Identifier: Apache-2.0
// The numbers of an experiment as CSV files.
#pragma once

#include <string>

#include "knuckle/experiment/scores.h"

namespace knuckle {

/// sequence, method, and the measures of each segmentation. The same for every run.
std::string segmentation_csv(const ExperimentScores& scores);
/// sequence, method, and the measures of each estimation. The same for every run.
std::string poses_csv(const ExperimentScores& scores);
/// model, samples seen, least validation error. The same for every run; empty fields for what is not known.
std::string trainings_csv(const ExperimentScores& scores);

/// sequence, stage (segmentation | estimation), method, median_ms.
std::string frame_times_csv(const ExperimentScores& scores);
/// model, seconds.
std::string training_times_csv(const ExperimentScores& scores);

}  // namespace knuckle
