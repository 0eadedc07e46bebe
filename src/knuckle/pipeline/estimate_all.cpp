// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/estimate_all.h"

#include "knuckle/core/error.h"
#include "knuckle/core/progress.h"
#include "knuckle/pipeline/duration_histogram.h"

namespace knuckle {

std::vector<FrameEstimate> estimate_all(const FrameSource& source, const Pipeline& pipeline, Start start,
                                        std::string_view source_name) {
  require_start(source, start, source_name);
  std::vector<FrameEstimate> frames;
  frames.reserve(static_cast<std::size_t>(source.size()));
  Progress progress("estimate", "frames", source.size());
  estimate_each(source, pipeline, {.start = start}, [&](FrameResult result) {
    if (!result.fault.empty()) throw Error(result.fault);
    frames.push_back(std::move(result.estimate));
    progress.advance();
  });
  return frames;
}

HandPose pose_of(const FrameEstimate& frame, const Convention& convention, int rank) {
  const auto index = static_cast<std::size_t>(rank);
  return index < frame.hands.size() ? frame.hands[index].pose : HandPose::missing(convention);
}

std::vector<HandPose> poses_of(std::span<const FrameEstimate> frames, const Convention& convention,
                               int rank) {
  std::vector<HandPose> poses;
  for (const FrameEstimate& frame : frames) poses.push_back(pose_of(frame, convention, rank));
  return poses;
}

double median_ms(std::span<const FrameEstimate> frames) {
  DurationHistogram times;
  for (const FrameEstimate& frame : frames) times.add(frame.times.total_ms());
  return times.median_ms().value_or(0.0);
}

}  // namespace knuckle
