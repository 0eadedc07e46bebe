// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/estimate_summary.h"

#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace knuckle {
namespace {

using Json = nlohmann::ordered_json;

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json median_of(const DurationHistogram& durations) {
  const std::optional<double> median = durations.median_ms();
  return median ? Json(*median) : Json(nullptr);
}

Json medians_of(const StageDurations& durations) {
  return {{"segment", median_of(durations.segment)},
          {"patch", median_of(durations.patch)},
          {"estimate", median_of(durations.estimate)},
          {"refine", median_of(durations.refine)},
          {"total", median_of(durations.total)}};
}

/// Of a hand's joints, with three digits; null where there is no such hand or the method gives none.
Json confidence_of(const FrameNote& note, std::size_t rank) {
  if (rank >= note.confidence.size() || note.confidence[rank].empty()) return nullptr;
  Json confidence = Json::array();
  for (const double value : note.confidence[rank]) confidence.push_back(std::round(value * 1000.0) / 1000.0);
  return confidence;
}

/// Writes a JSON array one item per line, as its items come.
class ArrayWriter {
 public:
  ArrayWriter(std::ostream& out, std::string_view name) : out_(out) {
    out_ << ",\n  " << text_of(std::string(name)) << ": [";
  }
  ArrayWriter(const ArrayWriter&) = delete;
  ArrayWriter& operator=(const ArrayWriter&) = delete;
  ~ArrayWriter() { out_ << (is_empty_ ? "]" : "\n  ]"); }

  void add(const Json& item) {
    out_ << (is_empty_ ? "\n    " : ",\n    ") << text_of(item);
    is_empty_ = false;
  }

 private:
  std::ostream& out_;
  bool is_empty_ = true;
};

void write_frames_without_hand(std::ostream& out, const VisitNotes& notes) {
  ArrayWriter frames(out, "frames_without_hand");
  std::int64_t frame = 0;
  notes([&](const FrameNote& note) {
    if (note.confidence.empty()) {
      frames.add({{"frame", frame}, {"reason", note.status}});
    }
    ++frame;
  });
}

void write_confidences(std::ostream& out, const VisitNotes& notes, std::size_t rank) {
  ArrayWriter confidences(out, rank == 0 ? "confidence" : fmt::format("confidence.hand{}", rank + 1));
  notes([&](const FrameNote& note) { confidences.add(confidence_of(note, rank)); });
}

}  // namespace

void StageDurations::add(const StageTimes& times) {
  segment.add(times.segment_ms);
  patch.add(times.patch_ms);
  estimate.add(times.estimate_ms);
  refine.add(times.refine_ms);
  total.add(times.total_ms());
}

void write_summary(std::ostream& out, const SummaryFacts& facts, const StageDurations& durations,
                   const VisitNotes& notes) {
  const RunCounts counts = counts_of(notes);
  const Json head = {{"source", facts.source},
                     {"convention", facts.convention},
                     {"frames", counts.frames},
                     {"found", counts.found},
                     {"unsure", counts.unsure},
                     {"unreadable", counts.unreadable},
                     {"median_ms", medians_of(durations)}};
  const char* separator = "{\n  ";
  for (const auto& [name, value] : head.items()) {
    out << separator << text_of(name) << ": " << text_of(value);
    separator = ",\n  ";
  }
  write_frames_without_hand(out, notes);
  for (std::size_t rank = 0; rank < std::max<std::size_t>(counts.most_hands, 1); ++rank) {
    write_confidences(out, notes, rank);
  }
  out << "\n}\n";
}

std::string summary_json(std::span<const FrameEstimate> frames, std::string_view source_name,
                         const Convention& convention) {
  StageDurations durations;
  for (const FrameEstimate& frame : frames) durations.add(frame.times);
  std::ostringstream out;
  const auto notes = [&](const std::function<void(const FrameNote&)>& visit) {
    for (const FrameEstimate& frame : frames) visit(note_of(frame));
  };
  write_summary(out, {std::string(source_name), std::string(convention.name)}, durations, notes);
  return out.str();
}

}  // namespace knuckle
