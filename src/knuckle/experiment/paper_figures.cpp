// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/paper_figures.h"

#include <fmt/format.h>

#include "knuckle/eval/pictures/score_figures.h"

namespace knuckle {
namespace {

/// The figure as the panel of a sensor.
Figure panel(Figure figure, std::string_view row, const SequenceScores& sequence) {
  figure.name = fmt::format("{}_{}", row, sequence.name);
  figure.title = fmt::format("{}: {}", sequence.title, figure.title);
  return figure;
}

}  // namespace

std::vector<Figure> figure4(const ExperimentScores& scores) {
  std::vector<Figure> panels;
  for (const SequenceScores& sequence : scores.sequences) {
    if (sequence.segmentation.empty()) continue;
    panels.push_back(panel(overlap_figure(sequence.segmentation), "figure4", sequence));
  }
  return panels;
}

Figure5 figure5(const ExperimentScores& scores) {
  Figure5 rows;
  for (const SequenceScores& sequence : scores.sequences) {
    if (!sequence.evaluation) continue;
    rows.joints_2d.push_back(panel(joints_2d_figure(*sequence.evaluation), "figure5_2d", sequence));
    rows.joints_3d.push_back(panel(joints_3d_figure(*sequence.evaluation), "figure5_3d", sequence));
    rows.all_joints_within.push_back(
        panel(all_joints_figure(*sequence.evaluation), "figure5_frames", sequence));
  }
  return rows;
}

}  // namespace knuckle
