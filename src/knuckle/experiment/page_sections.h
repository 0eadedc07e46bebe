// SPDX-License-Identifier: Apache-2.0
// The parts of an experiment's page, as HTML.
#pragma once

#include <string>
#include <vector>

#include "knuckle/eval/report/report.h"
#include "knuckle/experiment/claims.h"
#include "knuckle/experiment/plan.h"
#include "knuckle/experiment/scores.h"

namespace knuckle {

/// Title, what was compared on what, and a warning where the experiment was made small.
std::string summary_section(const ExperimentPlan& plan, const ExperimentScores& scores, double scale);

/// Each claim with its verdict and numbers.
std::string claims_section(const std::vector<Claim>& claims);

/// Overlap of estimated and true boxes: panels, and tables of means.
std::string figure4_section(const ExperimentScores& scores, const std::vector<DrawnFigure>& panels);

/// The drawn rows of Figure 5.
struct DrawnFigure5 {
  std::vector<DrawnFigure> joints_2d;
  std::vector<DrawnFigure> joints_3d;
  std::vector<DrawnFigure> all_joints_within;
};

/// Errors of the joints: panels, and tables of means.
std::string figure5_section(const ExperimentScores& scores, const DrawnFigure5& rows);

/// A frame of each sequence as every method sees it.
std::string examples_section(const ExperimentScores& scores);

/// What frames and trainings take.
std::string times_section(const ExperimentScores& scores);

/// How the measures are meant, and where the numbers lie.
std::string files_section(const ExperimentScores& scores);

}  // namespace knuckle
