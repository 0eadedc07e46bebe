// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/metrics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr int kCurveEndMm = 80;
constexpr int kCurveEndPx = 40;

std::vector<double> without_nan(std::span<const double> values) {
  std::vector<double> kept;
  kept.reserve(values.size());
  std::ranges::copy_if(values, std::back_inserter(kept), [](double value) { return !std::isnan(value); });
  return kept;
}

std::vector<double> finite(std::span<const double> values) {
  std::vector<double> kept;
  kept.reserve(values.size());
  std::ranges::copy_if(values, std::back_inserter(kept), [](double value) { return std::isfinite(value); });
  return kept;
}

/// 0, 1, ..., end.
std::vector<double> whole_steps_to(int end) {
  std::vector<double> thresholds(end + 1);
  std::iota(thresholds.begin(), thresholds.end(), 0.0);
  return thresholds;
}

/// Fraction of `sorted` that is at most the threshold.
double fraction_within(const std::vector<double>& sorted, double threshold) {
  const auto end = std::ranges::upper_bound(sorted, threshold);
  return static_cast<double>(end - sorted.begin()) / static_cast<double>(sorted.size());
}

std::vector<double> fractions_within(std::vector<double> errors, const std::vector<double>& thresholds) {
  std::ranges::sort(errors);
  std::vector<double> fractions;
  for (const double threshold : thresholds) fractions.push_back(fraction_within(errors, threshold));
  return fractions;
}

/// The mean error of each frame's known joints, and the largest one.
struct FrameErrors {
  std::vector<double> mean;
  std::vector<double> largest;
};

FrameErrors frame_errors(const JointErrors& errors) {
  FrameErrors result;
  for (std::int64_t frame = 0; frame < errors.frames; ++frame) {
    const std::vector<double> known = without_nan(errors.frame_3d_mm(frame));
    result.mean.push_back(mean(known));
    result.largest.push_back(known.empty() ? kNaN : *std::ranges::max_element(known));
  }
  return result;
}

/// The area under PCK(D) = #(e <= D) / n for D in [0, limit]: each joint adds limit - e, in closed form.
double normalised_pck_area(std::span<const double> known_errors) {
  double area = 0.0;
  for (const double error : known_errors) area += std::max(0.0, 1.0 - error / kAucLimitMm);
  return area / static_cast<double>(known_errors.size());
}

std::vector<double> column(const std::vector<double>& table, std::size_t columns, std::size_t index) {
  std::vector<double> values;
  for (std::size_t i = index; i < table.size(); i += columns) values.push_back(table[i]);
  return values;
}

JointScore score_joint(const JointErrors& errors, std::size_t joint) {
  const std::vector<double> in_3d = finite(column(errors.distance_3d_mm, errors.joints.size(), joint));
  const std::vector<double> in_2d = finite(column(errors.distance_2d_px, errors.joints.size(), joint));
  return {errors.joints[joint], static_cast<std::int64_t>(in_3d.size()),
          mean(in_3d),          median(in_3d),
          mean(in_2d),          median(in_2d)};
}

}  // namespace

MethodScore score(const JointErrors& errors, const std::string& name) {
  const FrameErrors frames = frame_errors(errors);
  const std::vector<double> known = without_nan(errors.distance_3d_mm);
  const std::vector<double> largest = without_nan(frames.largest);

  MethodScore result;
  result.name = name;
  result.frames = errors.frames;
  result.scored_frames = static_cast<std::int64_t>(largest.size());
  result.missing = std::ranges::count_if(largest, [](double error) { return std::isinf(error); });
  result.only_in_truth = errors.only_in_truth;
  result.only_in_predictions = errors.only_in_predictions;
  for (std::size_t j = 0; j < errors.joints.size(); ++j) result.joints.push_back(score_joint(errors, j));
  result.mean_3d_mm = mean(finite(known));
  result.median_3d_mm = median(finite(known));
  result.mean_2d_px = mean(finite(errors.distance_2d_px));
  result.median_2d_px = median(finite(errors.distance_2d_px));
  result.auc_pck_0_50 = normalised_pck_area(known);

  ErrorCurves& curves = result.curves;
  curves.threshold_mm = whole_steps_to(kCurveEndMm);
  curves.all_joints_within = fractions_within(largest, curves.threshold_mm);
  curves.mean_within = fractions_within(without_nan(frames.mean), curves.threshold_mm);
  curves.joints_within = fractions_within(known, curves.threshold_mm);
  curves.threshold_px = whole_steps_to(kCurveEndPx);
  curves.joints_within_px = fractions_within(without_nan(errors.distance_2d_px), curves.threshold_px);
  for (std::size_t i = 0; i < kTableThresholdsMm.size(); ++i) {
    result.frames_all_joints_within[i] = curves.all_joints_within[kTableThresholdsMm[i]];
  }
  result.frame_mean_3d_mm = frames.mean;
  result.frame_largest_3d_mm = frames.largest;
  return result;
}

}  // namespace knuckle
