// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/frame_note.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"

namespace knuckle {

FrameNote note_of(const FrameEstimate& estimate, std::string_view fault) {
  FrameNote note{estimate.status, std::string(fault), {}};
  for (const HandEstimate& hand : estimate.hands) note.confidence.push_back(hand.pose.confidence);
  return note;
}

std::string note_as_line(const FrameNote& note) {
  nlohmann::ordered_json line;
  line["status"] = note.status;
  if (!note.fault.empty()) line["fault"] = note.fault;
  line["confidence"] = note.confidence;
  // File names need not be UTF-8.
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

FrameNote note_from_line(std::string_view line) {
  try {
    const nlohmann::json json = nlohmann::json::parse(line);
    return {json.at("status"), json.value("fault", std::string()), json.at("confidence")};
  } catch (const nlohmann::json::exception&) {
    fail("a run's journal was damaged: '{}' is not the note of a frame", line);
  }
}

RunCounts counts_of(const VisitNotes& notes) {
  RunCounts counts;
  notes([&](const FrameNote& note) {
    if (!note.fault.empty() && ++counts.unreadable == 1) {
      counts.first_fault = counts.frames;
      counts.fault = note.fault;
    }
    counts.found += note.confidence.empty() ? 0 : 1;
    counts.unsure += !note.confidence.empty() && note.status == kUnsure ? 1 : 0;
    counts.most_hands = std::max(counts.most_hands, note.confidence.size());
    ++counts.frames;
  });
  return counts;
}

}  // namespace knuckle
