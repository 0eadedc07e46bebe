// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/run.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/file_io.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/stopwatch.h"

namespace knuckle {
namespace {

constexpr std::string_view kBoxesHead = "frame,found,x,y,width,height,milliseconds";

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

FrameSegmentation best_of(const Segmentation& segmentation, double milliseconds) {
  if (segmentation.hands.empty()) return {false, {}, milliseconds};
  return {true, segmentation.hands.front().box, milliseconds};
}

template <class Measure>
double median_over(std::span<const FrameEstimate> frames, const Measure& measure) {
  if (frames.empty()) return 0.0;
  std::vector<double> values;
  for (const FrameEstimate& frame : frames) values.push_back(measure(frame.times));
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
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
    return best_of(segmentation, watch.milliseconds());
  });
}

std::string boxes_csv(std::span<const FrameSegmentation> frames) {
  std::string csv = std::string(kBoxesHead) + "\n";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& [found, box, milliseconds] = frames[i];
    csv += fmt::format("{},{},{},{},{},{},{:.3f}\n", i, found ? 1 : 0, box.x, box.y, box.width, box.height,
                       milliseconds);
  }
  return csv;
}

std::vector<FrameSegmentation> read_boxes_csv(const std::filesystem::path& path) {
  const std::vector<std::string> lines = read_lines(path);
  if (lines.empty() || lines.front() != kBoxesHead) {
    fail("{}:1: expected the head '{}'", path.string(), kBoxesHead);
  }
  std::vector<FrameSegmentation> frames;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::string where = fmt::format("{}:{}", path.string(), i + 1);
    const std::vector<double> values = parse_numbers(lines[i], where);
    if (values.size() != 7) fail("{}: holds {} values, expected 7", where, values.size());
    if (values[0] != static_cast<double>(frames.size())) {
      fail("{}: is of frame {}, expected {}", where, values[0], frames.size());
    }
    const Box box{static_cast<int>(values[2]), static_cast<int>(values[3]), static_cast<int>(values[4]),
                  static_cast<int>(values[5])};
    frames.push_back({values[1] != 0.0, box, values[6]});
  }
  return frames;
}

std::vector<FrameEstimate> estimate_all(const FrameSource& source, const Pipeline& pipeline, Start start,
                                        std::string_view source_name) {
  require_start(source, start, source_name);
  return process_all<FrameEstimate>(source, "estimate", [&](const Frame& frame) {
    return pipeline.estimate(frame, start_in(frame, start));
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
      summary["frames_without_hand"].push_back({{"frame", i}, {"reason", frames[i].reason}});
    }
  }
  return summary.dump(2) + "\n";
}

}  // namespace knuckle
