// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/run_summary.h"

#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/pose.h"
#include "knuckle/core/text_file.h"

namespace knuckle {
namespace {

/// What `take` reads from the file; a key that is missing or of another kind is the file's fault, too.
template <class Take>
auto taken_from(const std::filesystem::path& path, const Take& take) {
  try {
    return take(nlohmann::json::parse(read_text_file(path)));
  } catch (const nlohmann::json::exception& error) {
    fail("{}: no summary of a run: {}", path.string(), error.what());
  }
}

}  // namespace

SegmentationSummary read_segmentation_summary(const std::filesystem::path& path) {
  return taken_from(path, [](const nlohmann::json& summary) -> SegmentationSummary {
    const double iou = summary.contains("mask") ? summary["mask"].at("pixel_iou").get<double>() : kNaN;
    return {.median_ms = summary.at("median_ms").get<double>(), .mask_iou = iou};
  });
}

double read_inference_ms(const std::filesystem::path& path) {
  return taken_from(path, [](const nlohmann::json& summary) {
    const nlohmann::json& times = summary.at("median_ms");
    return times.at("patch").get<double>() + times.at("estimate").get<double>() +
           times.at("refine").get<double>();
  });
}

}  // namespace knuckle
