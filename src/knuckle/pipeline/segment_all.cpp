// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/segment_all.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/ordered_work.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/statistics.h"
#include "knuckle/pipeline/stopwatch.h"

namespace knuckle {
namespace {

constexpr int kJobsPerThread = 4;

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

double median_or_zero(std::vector<double> values) {
  return values.empty() ? 0.0 : upper_median(std::span(values));
}

FrameSegmentation segmentation_of(const Frame& frame, const HandFinder& finder, Start start) {
  const Stopwatch watch;
  const Segmentation segmentation = finder.find(frame, start_in(frame, start));
  const double milliseconds = watch.milliseconds();
  return best_of(segmentation, frame, milliseconds);
}

}  // namespace

void segment_each(const FrameSource& source, const HandFinder& finder, Start start,
                  std::string_view source_name, const TakeSegmentation& take) {
  require_start(source, start, source_name);
  std::int64_t index = 0;
  const auto next = [&]() -> Job {
    if (index == source.size()) return {};
    return [&, number = index++]() -> Delivery {
      return [&, found = segmentation_of(source.read(number), finder, start)] { take(found); };
    };
  };
  run_in_order(next, kJobsPerThread * thread_count());
}

std::vector<FrameSegmentation> segment_all(const FrameSource& source, const HandFinder& finder, Start start,
                                           std::string_view source_name) {
  std::vector<FrameSegmentation> frames;
  Progress progress("segment", "frames", source.size());
  segment_each(source, finder, start, source_name, [&](const FrameSegmentation& frame) {
    frames.push_back(frame);
    progress.advance();
  });
  return frames;
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
  summary["median_ms"] = median_or_zero(std::move(times));
  if (!overlaps.empty()) {
    const double sum = std::accumulate(overlaps.begin(), overlaps.end(), 0.0);
    summary["mask"] = {{"frames", overlaps.size()},
                       {"mean_iou", sum / static_cast<double>(overlaps.size())},
                       {"median_iou", median_or_zero(overlaps)},
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

}  // namespace knuckle
