// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/score_figures.h"

#include <algorithm>

namespace knuckle {
namespace {

std::vector<double> in_percent(const std::vector<double>& fractions) {
  std::vector<double> percent;
  for (const double fraction : fractions) percent.push_back(100.0 * fraction);
  return percent;
}

Figure curve_figure(const Evaluation& evaluation, std::vector<double> ErrorCurves::*thresholds,
                    std::vector<double> ErrorCurves::*fractions) {
  Figure figure;
  figure.x_label = thresholds == &ErrorCurves::threshold_mm ? "distance D (mm)" : "distance R (px)";
  for (const MethodScore& method : evaluation.methods) {
    figure.x = method.curves.*thresholds;
    figure.series.push_back({method.name, in_percent(method.curves.*fractions)});
  }
  return figure;
}

/// Every landmark that some method was compared in, in the truth's order.
std::vector<Landmark> compared_landmarks(const Evaluation& evaluation) {
  std::vector<Landmark> landmarks;
  for (const Landmark landmark : evaluation.convention.landmarks) {
    const bool is_compared = std::ranges::any_of(evaluation.methods, [&](const MethodScore& method) {
      return std::ranges::find(method.joints, landmark, &JointScore::landmark) != method.joints.end();
    });
    if (is_compared) landmarks.push_back(landmark);
  }
  return landmarks;
}

/// A group of bars per joint, and the mean of all at the end.
Figure joint_figure(const Evaluation& evaluation, double JointScore::*joint_error,
                    double MethodScore::*mean) {
  Figure figure;
  figure.kind = FigureKind::bars;
  const std::vector<Landmark> landmarks = compared_landmarks(evaluation);
  for (const Landmark landmark : landmarks) figure.categories.emplace_back(name_of(landmark));
  figure.categories.emplace_back("mean");
  for (const MethodScore& method : evaluation.methods) {
    Series series{method.name, {}};
    for (const Landmark landmark : landmarks) {
      const auto joint = std::ranges::find(method.joints, landmark, &JointScore::landmark);
      series.values.push_back(joint == method.joints.end() ? kNaN : (*joint).*joint_error);
    }
    series.values.push_back(method.*mean);
    figure.series.push_back(series);
  }
  return figure;
}

Figure named(Figure figure, std::string name, std::string title, std::string y_label) {
  figure.name = std::move(name);
  figure.title = std::move(title);
  figure.y_label = std::move(y_label);
  return figure;
}

}  // namespace

Figure all_joints_figure(const Evaluation& evaluation) {
  return named(curve_figure(evaluation, &ErrorCurves::threshold_mm, &ErrorCurves::all_joints_within),
               "all_joints_within", "Frames with all joints within D", "frames (%)");
}

Figure joints_3d_figure(const Evaluation& evaluation) {
  return named(joint_figure(evaluation, &JointScore::mean_3d_mm, &MethodScore::mean_3d_mm), "joints_3d",
               "Mean 3D error of each joint", "error (mm)");
}

Figure joints_2d_figure(const Evaluation& evaluation) {
  return named(joint_figure(evaluation, &JointScore::mean_2d_px, &MethodScore::mean_2d_px), "joints_2d",
               "Mean 2D error of each joint", "error (px)");
}

std::vector<Figure> figures_of(const Evaluation& evaluation) {
  return {
      all_joints_figure(evaluation),
      named(curve_figure(evaluation, &ErrorCurves::threshold_mm, &ErrorCurves::mean_within), "mean_within",
            "Frames with the mean joint error within D", "frames (%)"),
      named(curve_figure(evaluation, &ErrorCurves::threshold_mm, &ErrorCurves::joints_within),
            "joints_within", "Joints within D (PCK)", "joints (%)"),
      named(curve_figure(evaluation, &ErrorCurves::threshold_px, &ErrorCurves::joints_within_px),
            "joints_within_px", "Joints within R in the image", "joints (%)"),
      joints_3d_figure(evaluation),
      joints_2d_figure(evaluation),
  };
}

Figure overlap_figure(std::span<const SegmentationScore> scores) {
  Figure figure;
  figure.x_label = "threshold t";
  for (const SegmentationScore& score : scores) {
    figure.x = score.threshold;
    figure.series.push_back({score.name, in_percent(score.fraction_above)});
  }
  return named(figure, "overlap", "Frames with box overlap r > t", "frames (%)");
}

Figure reliability_figure(std::span<const FollowedScore> scores) {
  constexpr std::int64_t kFewestJointsShown = 20;  // the share of fewer says nothing
  Figure figure;
  for (int i = 0; i < kReliabilityBins; ++i) figure.x.push_back((i + 0.5) / kReliabilityBins);
  for (const FollowedScore& score : scores) {
    if (score.reliability.joints == 0) continue;
    Series series{score.name, {}};
    for (const ReliabilityBin& bin : score.reliability.bins)
      series.values.push_back(bin.joints < kFewestJointsShown ? kNaN : 100.0 * bin.within);
    figure.series.push_back(std::move(series));
  }
  Series calibrated{"calibrated", {}};
  for (const double confidence : figure.x) calibrated.values.push_back(100.0 * confidence);
  figure.series.push_back(std::move(calibrated));
  figure.x_label = "confidence of a joint";
  return named(std::move(figure), "reliability", "Joints that lie within 20 mm, by their confidence",
               "joints within 20 mm (%)");
}

}  // namespace knuckle
