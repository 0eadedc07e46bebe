// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/run.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/pipeline/stopwatch.h"

namespace knuckle {
namespace {

/// Calls `process(frame)` for every frame of the source and keeps what it returns, in the source's order.
template <class Result, class Process>
std::vector<Result> process_all(const FrameSource& source, std::string_view what, const Process& process) {
  std::vector<Result> results(static_cast<std::size_t>(source.size()));
  Progress progress{std::string(what), "frames", source.size()};
  parallel_for(source.size(), [&](std::int64_t i) {
    results[static_cast<std::size_t>(i)] = process(source.read(i));
    progress.advance();
  });
  return results;
}

void require_start(const FrameSource& source, Start start, std::string_view source_name) {
  if (start == Start::truth && !source.convention()) {
    fail("{}: segmentation was to start at the truth, but the source has none", source_name);
  }
}

/// Of the best hand, with the frame's true mask.
FrameSegmentation::MaskOverlap mask_overlap(const Segmentation& segmentation,
                                            const Image<std::uint8_t>& truth) {
  FrameSegmentation::MaskOverlap overlap;
  for (const std::uint8_t pixel : truth.pixels()) overlap.in_either += pixel != 0 ? 1 : 0;
  if (segmentation.hands.empty()) return overlap;
  const HandRegion& hand = segmentation.hands.front();
  for (int row = 0; row < hand.box.height; ++row) {
    for (int column = 0; column < hand.box.width; ++column) {
      if (hand.mask(column, row) == 0) continue;
      const bool is_true = truth(hand.box.x + column, hand.box.y + row) != 0;
      ++(is_true ? overlap.in_both : overlap.in_either);
    }
  }
  return overlap;
}

FrameSegmentation best_of(const Segmentation& segmentation, const Frame& frame, double milliseconds) {
  FrameSegmentation best;
  best.found = !segmentation.hands.empty();
  best.milliseconds = milliseconds;
  if (best.found) best.box = segmentation.hands.front().box;
  if (!frame.mask.empty()) best.mask = mask_overlap(segmentation, frame.mask);
  return best;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

template <class Measure>
double median_over(std::span<const FrameEstimate> frames, const Measure& measure) {
  std::vector<double> values;
  for (const FrameEstimate& frame : frames) values.push_back(measure(frame.times));
  return median_of(values);
}

}  // namespace

Start start_from_name(std::string_view name) {
  if (name == "nearest") return Start::nearest;
  if (name == "truth") return Start::truth;
  fail("start is '{}', expected nearest or truth", name);
}

std::optional<Point3> start_in(const Frame& frame, Start start) {
  return start == Start::truth ? true_start(frame) : std::nullopt;
}

std::vector<FrameSegmentation> segment_all(const FrameSource& source, const HandFinder& finder, Start start,
                                           std::string_view source_name) {
  require_start(source, start, source_name);
  return process_all<FrameSegmentation>(source, "segment", [&](const Frame& frame) {
    const Stopwatch watch;
    const Segmentation segmentation = finder.find(frame, start_in(frame, start));
    const double milliseconds = watch.milliseconds();
    return best_of(segmentation, frame, milliseconds);
  });
}

double FrameSegmentation::MaskOverlap::iou() const {
  return in_either == 0 ? 1.0 : static_cast<double>(in_both) / static_cast<double>(in_either);
}

std::string summary_json(std::span<const FrameSegmentation> frames, std::string_view source_name) {
  std::vector<double> times;
  std::vector<double> overlaps;
  FrameSegmentation::MaskOverlap all;
  for (const FrameSegmentation& frame : frames) {
    times.push_back(frame.milliseconds);
    if (!frame.mask) continue;
    overlaps.push_back(frame.mask->iou());
    all.in_both += frame.mask->in_both;
    all.in_either += frame.mask->in_either;
  }
  nlohmann::ordered_json summary;
  summary["source"] = source_name;
  summary["frames"] = frames.size();
  summary["found"] = std::ranges::count_if(frames, &FrameSegmentation::found);
  summary["median_ms"] = median_of(times);
  if (!overlaps.empty()) {
    const double sum = std::accumulate(overlaps.begin(), overlaps.end(), 0.0);
    summary["mask"] = {{"frames", overlaps.size()},
                       {"mean_iou", sum / static_cast<double>(overlaps.size())},
                       {"median_iou", median_of(overlaps)},
                       {"pixel_iou", all.iou()}};
  }
  return summary.dump(2) + "\n";
}

std::string boxes_csv(std::span<const FrameSegmentation> frames) {
  std::string csv = "frame,found,x,y,width,height,milliseconds\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Box& box = frames[i].box;
    csv += fmt::format("{},{},{},{},{},{},{:.3f}\n", i, frames[i].found ? 1 : 0, box.x, box.y, box.width,
                       box.height, frames[i].milliseconds);
  }
  return csv;
}

std::vector<FrameEstimate> estimate_all(const FrameSource& source, const Pipeline& pipeline, Start start,
                                        std::string_view source_name) {
  require_start(source, start, source_name);
  return process_all<FrameEstimate>(source, "estimate", [&](const Frame& frame) {
    return pipeline.estimate(frame,
                             {.start = start_in(frame, start), .max_hands = pipeline.hand().max_hands});
  });
}

std::vector<HandPose> poses_of(std::span<const FrameEstimate> frames, const Convention& convention,
                               int rank) {
  std::vector<HandPose> poses;
  for (const FrameEstimate& frame : frames) {
    const bool has_hand = rank < static_cast<int>(frame.hands.size());
    poses.push_back(has_hand ? frame.hands[static_cast<std::size_t>(rank)].pose
                             : HandPose::missing(convention));
  }
  return poses;
}

double median_ms(std::span<const FrameEstimate> frames) {
  return median_over(frames, [](const StageTimes& t) { return t.total_ms(); });
}

namespace {

/// Of a hand's joints, with three digits; null where there is no such hand or the method gives none.
nlohmann::ordered_json confidence_of(const FrameEstimate& frame, std::size_t rank) {
  if (rank >= frame.hands.size() || frame.hands[rank].pose.confidence.empty()) return nullptr;
  nlohmann::ordered_json confidence = nlohmann::ordered_json::array();
  for (const double value : frame.hands[rank].pose.confidence) {
    confidence.push_back(std::round(value * 1000.0) / 1000.0);
  }
  return confidence;
}

nlohmann::ordered_json confidences_of(std::span<const FrameEstimate> frames, std::size_t rank) {
  nlohmann::ordered_json confidences = nlohmann::ordered_json::array();
  for (const FrameEstimate& frame : frames) confidences.push_back(confidence_of(frame, rank));
  return confidences;
}

}  // namespace

std::string summary_json(std::span<const FrameEstimate> frames, std::string_view source_name,
                         const Convention& convention) {
  nlohmann::ordered_json summary;
  summary["source"] = source_name;
  summary["convention"] = convention.name;
  summary["frames"] = frames.size();
  summary["found"] =
      std::ranges::count_if(frames, [](const FrameEstimate& frame) { return !frame.hands.empty(); });
  summary["median_ms"] = {
      {"segment", median_over(frames, [](const StageTimes& t) { return t.segment_ms; })},
      {"patch", median_over(frames, [](const StageTimes& t) { return t.patch_ms; })},
      {"estimate", median_over(frames, [](const StageTimes& t) { return t.estimate_ms; })},
      {"refine", median_over(frames, [](const StageTimes& t) { return t.refine_ms; })},
      {"total", median_ms(frames)}};
  summary["frames_without_hand"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].hands.empty()) {
      summary["frames_without_hand"].push_back({{"frame", i}, {"reason", frames[i].status}});
    }
  }
  summary["confidence"] = confidences_of(frames, 0);
  std::size_t most_hands = 0;
  for (const FrameEstimate& frame : frames) most_hands = std::max(most_hands, frame.hands.size());
  for (std::size_t rank = 1; rank < most_hands; ++rank) {
    summary[fmt::format("confidence.hand{}", rank + 1)] = confidences_of(frames, rank);
  }
  return summary.dump(2) + "\n";
}

}  // namespace knuckle
