// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/tables.h"

#include <cmath>
#include <iterator>

#include <fmt/format.h>

#include "knuckle/eval/metrics/score_files.h"

namespace knuckle {
namespace {

constexpr std::size_t kHalf = 50;  // the threshold t = 0.5 of a curve with a value per hundredth
constexpr std::size_t kThreeQuarters = 75;

template <class... Values>
void add_row(std::string& csv, const std::string& sequence, const std::string& method,
             fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(csv), "{},{},", csv_field(sequence), csv_field(method));
  fmt::format_to(std::back_inserter(csv), format, std::forward<Values>(values)...);
  csv.push_back('\n');
}

/// Empty where it is not known.
std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string();
}

}  // namespace

std::string segmentation_csv(const ExperimentScores& scores) {
  std::string csv =
      "sequence,method,frames,missing,mean_iou,median_iou,frames_above_0.50,frames_above_0.75,mask_iou\n";
  for (const SequenceScores& sequence : scores.sequences) {
    for (std::size_t i = 0; i < sequence.segmentation.size(); ++i) {
      const SegmentationScore& score = sequence.segmentation[i];
      add_row(csv, sequence.name, score.name, "{},{},{:.6f},{:.6f},{:.6f},{:.6f},{}", score.frames,
              score.missing, score.mean_iou, score.median_iou, score.fraction_above.at(kHalf),
              score.fraction_above.at(kThreeQuarters), number(sequence.mask_iou[i], 6));
    }
  }
  return csv;
}

std::string poses_csv(const ExperimentScores& scores) {
  std::string csv = "sequence,method,frames,missing,mean_3d_mm,median_3d_mm,mean_2d_px,median_2d_px";
  for (const int threshold : kTableThresholdsMm)
    csv += fmt::format(",frames_all_joints_within_{}_mm", threshold);
  csv += ",auc_pck_0_50\n";
  for (const SequenceScores& sequence : scores.sequences) {
    if (!sequence.evaluation) continue;
    for (const MethodScore& score : sequence.evaluation->methods) {
      std::string within;
      for (const double share : score.frames_all_joints_within) within += fmt::format(",{:.6f}", share);
      add_row(csv, sequence.name, score.name, "{},{},{},{},{},{}{},{:.6f}", score.frames, score.missing,
              number(score.mean_3d_mm, 4), number(score.median_3d_mm, 4), number(score.mean_2d_px, 4),
              number(score.median_2d_px, 4), within, score.auc_pck_0_50);
    }
  }
  return csv;
}

std::string trainings_csv(const ExperimentScores& scores) {
  std::string csv = "model,samples,validation_mm\n";
  for (const TrainingRecord& training : scores.trainings) {
    csv += fmt::format("{},{},{}\n", csv_field(training.model),
                       training.samples ? fmt::format("{}", *training.samples) : std::string(),
                       number(training.validation_mm, 3));
  }
  return csv;
}

std::string frame_times_csv(const ExperimentScores& scores) {
  std::string csv = "sequence,method,stage,median_ms\n";
  for (const SequenceScores& sequence : scores.sequences) {
    for (std::size_t i = 0; i < sequence.segmentation_ms.size(); ++i) {
      add_row(csv, sequence.name, sequence.segmentation[i].name, "segmentation,{:.4f}",
              sequence.segmentation_ms[i]);
    }
    for (std::size_t i = 0; i < sequence.estimation_ms.size(); ++i) {
      add_row(csv, sequence.name, sequence.evaluation->methods[i].name, "estimation,{:.4f}",
              sequence.estimation_ms[i]);
    }
  }
  return csv;
}

std::string training_times_csv(const ExperimentScores& scores) {
  std::string csv = "model,seconds\n";
  for (const TrainingRecord& training : scores.trainings) {
    csv += fmt::format("{},{}\n", csv_field(training.model),
                       training.seconds ? number(*training.seconds, 1) : "");
  }
  return csv;
}

}  // namespace knuckle
