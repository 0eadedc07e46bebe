// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/pipeline/duration_histogram.h"
#include "knuckle/pipeline/frame_note.h"

namespace knuckle {

/// How long the stages of a pipeline took over many frames.
struct StageDurations {
  DurationHistogram segment;
  DurationHistogram patch;
  DurationHistogram estimate;
  DurationHistogram refine;
  DurationHistogram total;

  void add(const StageTimes& times);
};

/// What the summary of a run says at its head.
struct SummaryFacts {
  std::string source;
  std::string convention;
};

/// Writes a run's summary as JSON, frame by frame: source, convention, counts, median times of each stage (of
/// the frames in `durations`, to 0.1 per cent; null where there are none), the frames without a hand with the
/// reason why, and for each frame the confidences of the surest hand's joints with three digits (null where
/// there are none); those of other hands under `confidence.hand2` and so on.
void write_summary(std::ostream& out, const SummaryFacts& facts, const StageDurations& durations,
                   const VisitNotes& notes);

/// The same of frames in memory.
std::string summary_json(std::span<const FrameEstimate> frames, std::string_view source_name,
                         const Convention& convention);

}  // namespace knuckle
