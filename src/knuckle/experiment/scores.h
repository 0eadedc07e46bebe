// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/eval/report/report.h"
#include "knuckle/experiment/layout.h"
#include "knuckle/experiment/plan.h"
#include "knuckle/experiment/training_record.h"

namespace knuckle {

/// How good and how fast the methods are on one sequence; methods in the plan's order.
struct SequenceScores {
  std::string name;   ///< of its folder
  std::string title;  ///< of its sensor
  std::vector<SegmentationScore> segmentation;
  std::vector<double> mask_iou;          ///< of all pixels with the true masks, NaN where there are none
  std::vector<double> segmentation_ms;   ///< median of a frame
  std::optional<Evaluation> evaluation;  ///< nothing where no estimation is planned
  std::vector<double> estimation_ms;     ///< median of crop, inference and refinement of a frame
  std::vector<GalleryRow> gallery;
};

/// What all methods reached on all sequences.
struct ExperimentScores {
  std::vector<SequenceScores> sequences;
  std::vector<TrainingRecord> trainings;  ///< one per model
};

/// Scores all boxes and poses of an experiment. `sources` has one per sequence.
ExperimentScores scored(const ExperimentPlan& plan, std::span<const std::string> sources,
                        const ExperimentFolder& folder);

}  // namespace knuckle
