// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/pipeline/estimate_each.h"

namespace knuckle {

/// What a run notes of each frame until its summary is written; without times, and the same in every run.
struct FrameNote {
  std::string status;  ///< `FrameEstimate::status`
  std::string fault;   ///< `FrameResult::fault`
  std::vector<std::vector<float>>
      confidence;  ///< one per hand: of each joint, or none where the method gives none
};

/// What a run notes of a frame; `fault` says why it could not be read.
FrameNote note_of(const FrameEstimate& estimate, std::string_view fault = {});

/// The note as one line of JSON.
std::string note_as_line(const FrameNote& note);
/// The note of a line that `note_as_line` made. Throws an Error where it is not one.
FrameNote note_from_line(std::string_view line);

/// Calls its argument with the note of each frame, in order; may be called again.
using VisitNotes = std::function<void(const std::function<void(const FrameNote&)>&)>;

/// What the notes of a run come to.
struct RunCounts {
  std::int64_t frames = 0;
  std::int64_t found = 0;        ///< frames with a hand
  std::int64_t unsure = 0;       ///< of these, those whose status says so
  std::int64_t unreadable = 0;   ///< frames with a fault
  std::int64_t first_fault = 0;  ///< frame of the first fault, where there is one
  std::string fault;             ///< the first
  std::size_t most_hands = 0;    ///< in one frame
};

/// Counts the notes of all frames.
RunCounts counts_of(const VisitNotes& notes);

}  // namespace knuckle
