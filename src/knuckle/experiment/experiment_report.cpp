// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment_report.h"

#include <cmath>
#include <functional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/file_io.h"
#include "knuckle/eval/boxes_file.h"
#include "knuckle/eval/report.h"
#include "knuckle/pipeline/open_source.h"

namespace knuckle {
namespace {

/// A file name for a method: "mean shift" becomes "mean_shift".
std::string file_stem(const std::string& name) {
  std::string stem = name;
  for (char& c : stem) {
    if (c == ' ' || c == '/') c = '_';
  }
  return stem;
}

/// One sequence, scored.
struct ScoredSequence {
  Report report;
  std::vector<double> mask_iou;         ///< of all pixels with the true masks, one a segmentation
  std::vector<double> segmentation_ms;  ///< median of a frame, one a segmentation
  std::vector<double> estimation_ms;    ///< the same of crop, inference and refinement, one an estimation
};

nlohmann::json read_json(const std::filesystem::path& path) {
  return nlohmann::json::parse(read_text_file(path));
}

double inference_ms(const nlohmann::json& summary) {
  const auto& times = summary.at("median_ms");
  return times.at("patch").get<double>() + times.at("estimate").get<double>() +
         times.at("refine").get<double>();
}

double mask_iou(const nlohmann::json& summary) {
  return summary.contains("mask") ? summary["mask"].at("pixel_iou").get<double>() : kNaN;
}

ScoredSequence scored(const ExperimentPlan& plan, const PlannedSequence& sequence,
                      const std::string& source_name, const std::filesystem::path& out) {
  const auto source = open_source(source_name);
  Truth truth = truth_from_source(*source, source_name);
  ScoredSequence result;
  result.report.id = sequence.name;
  result.report.title = sequence.title;
  for (const PlannedMethod& method : plan.segmentation) {
    const std::vector<Box> boxes = read_boxes_file(boxes_file(out, sequence, method));
    result.report.segmentation.push_back(score_boxes(method.name, boxes, truth.sequence.poses));
    const auto summary = read_json(summary_file(boxes_file(out, sequence, method)));
    result.segmentation_ms.push_back(summary.at("median_ms").get<double>());
    result.mask_iou.push_back(mask_iou(summary));
  }
  std::vector<Predictions> predictions;
  for (const PlannedMethod& method : plan.estimation) {
    predictions.push_back({method.name, read_poses_file(poses_file(out, sequence, method))});
    result.estimation_ms.push_back(inference_ms(read_json(summary_file(poses_file(out, sequence, method)))));
  }
  if (predictions.empty()) return result;
  for (HandPose& pose : truth.sequence.poses) pose = converted(pose, plan.convention);
  truth.sequence.convention = plan.convention;
  result.report.evaluation = evaluate(truth, predictions);
  result.report.gallery = make_gallery({source.get(), &truth, &*result.report.evaluation, predictions});
  return result;
}

/// Methods x sequences.
ReportTable overview_table(const std::string& title, const std::vector<PlannedMethod>& methods,
                           const std::vector<ScoredSequence>& sequences, int digits,
                           const std::function<double(const ScoredSequence&, std::size_t method)>& value) {
  ReportTable table{.title = title, .heads = {"method"}, .rows = {}, .note = {}};
  for (const ScoredSequence& sequence : sequences) table.heads.push_back(sequence.report.title);
  for (std::size_t i = 0; i < methods.size(); ++i) {
    std::vector<std::string> row = {methods[i].name};
    for (const ScoredSequence& sequence : sequences) {
      const double number = value(sequence, i);
      row.push_back(std::isfinite(number) ? fmt::format("{:.{}f}", number, digits) : "\u2013");
    }
    table.rows.push_back(row);
  }
  return table;
}

Report overview(const ExperimentPlan& plan, const std::vector<ScoredSequence>& sequences) {
  Report report;
  report.title = plan.title;
  const auto add = [&](const std::string& title, const std::vector<PlannedMethod>& methods, int digits,
                       const std::function<double(const ScoredSequence&, std::size_t)>& value) {
    if (!methods.empty()) report.tables.push_back(overview_table(title, methods, sequences, digits, value));
  };
  add("Segmentation: mean overlap r of boxes", plan.segmentation, 3,
      [](const auto& sequence, std::size_t i) { return sequence.report.segmentation[i].mean_iou; });
  add("Segmentation: IoU of all pixels with the true masks", plan.segmentation, 3,
      [](const auto& sequence, std::size_t i) { return sequence.mask_iou[i]; });
  add("Segmentation: median time of a frame on one thread (ms)", plan.segmentation, 2,
      [](const auto& sequence, std::size_t i) { return sequence.segmentation_ms[i]; });
  add("Pose: mean 3D error (mm)", plan.estimation, 2,
      [](const auto& sequence, std::size_t i) { return sequence.report.evaluation->methods[i].mean_3d_mm; });
  add("Pose: mean 2D error (px)", plan.estimation, 2,
      [](const auto& sequence, std::size_t i) { return sequence.report.evaluation->methods[i].mean_2d_px; });
  add("Pose: median time of a hand on one thread, after segmentation (ms)", plan.estimation, 2,
      [](const auto& sequence, std::size_t i) { return sequence.estimation_ms[i]; });
  return report;
}

}  // namespace

std::filesystem::path boxes_file(const std::filesystem::path& out, const PlannedSequence& sequence,
                                 const PlannedMethod& method) {
  return out / sequence.name / "boxes" / (file_stem(method.name) + ".csv");
}

std::filesystem::path poses_file(const std::filesystem::path& out, const PlannedSequence& sequence,
                                 const PlannedMethod& method) {
  return out / sequence.name / "poses" / (file_stem(method.name) + ".txt");
}

std::filesystem::path summary_file(std::filesystem::path result) {
  return result.replace_extension(".json");
}

void write_experiment_report(const ExperimentPlan& plan, std::span<const std::string> sources,
                             const std::filesystem::path& out) {
  std::vector<ScoredSequence> sequences;
  for (std::size_t i = 0; i < plan.sequences.size(); ++i) {
    sequences.push_back(scored(plan, plan.sequences[i], sources[i], out));
  }
  std::vector<Report> reports = {overview(plan, sequences)};
  for (ScoredSequence& sequence : sequences) reports.push_back(std::move(sequence.report));
  write_report(reports, out);
}

}  // namespace knuckle
