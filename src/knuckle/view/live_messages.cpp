// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/live_messages.h"

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "knuckle/hand/hand_flesh.h"
#include "knuckle/hand/landmark_definition.h"
#include "knuckle/view/message_parts.h"

namespace knuckle {
namespace {

Json recording_json(const RecordingState& recording) {
  Json json = {{"file", nullptr},
               {"frames", recording.frames},
               {"dropped", recording.dropped},
               {"fault", recording.fault}};
  if (!recording.file.empty()) json["file"] = recording.file;
  return json;
}

/// A list per hand.
Json surface_json(const FrameRecord& record) {
  Json hands = Json::array();
  for (const HandRecord& hand : record.hands) hands.push_back(flesh_json(hand));
  return hands;
}

/// What is said of a frame beside its images, without the braces around.
std::string fields_of(const LiveUpdate& update) {
  const Json others = {{"surface", surface_json(update.record)},
                       {"recording", recording_json(update.recording)},
                       {"arrived", update.arrived},
                       {"passed_over", update.passed_over}};
  const std::string text = text_of(others);
  return fmt::format("\"record\":{},{}", to_json_line(update.record), text.substr(1, text.size() - 2));
}

}  // namespace

std::vector<FleshPiece> flesh_of(const HandRecord& hand) {
  if (hand.skeleton.empty()) return {};
  SupersetPoints points;
  points.fill(Point3::Constant(kNaN));
  for (std::size_t i = 0; i < hand.landmarks_mm.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(hand.convention.landmarks[i]);
    if (landmark < points.size()) points[landmark] = hand.landmarks_mm[i];
  }
  const double palm_mm = palm_length(points);
  if (!std::isfinite(palm_mm)) return {};
  std::vector<FleshPiece> pieces;
  for (const HandFlesh& flesh : hand_flesh()) {
    const Point3& from = points[static_cast<std::size_t>(flesh.from)];
    const Point3& to = points[static_cast<std::size_t>(flesh.to)];
    if (!from.allFinite() || !to.allFinite()) continue;
    pieces.push_back({from.x(), from.y(), from.z(), flesh.radius_from * palm_mm, to.x(), to.y(), to.z(),
                      flesh.radius_to * palm_mm});
  }
  return pieces;
}

std::string info_message(const LiveInfo& info, const RecordingState& recording, const LiveUpdate* newest) {
  return text_of({{"version", info.version},
                  {"source", info.source},
                  {"camera", newest == nullptr ? Json() : camera_json(newest->frame->camera)},
                  {"convention", info.convention.name},
                  {"landmarks", landmarks_json(info.convention)},
                  {"bones", bones_json(info.convention)},
                  {"pipeline", info.pipeline},
                  {"recording", recording_json(recording)},
                  {"can_record", info.can_record}});
}

std::vector<std::uint8_t> frame_message(const LiveUpdate& update) {
  return image_message(*update.frame, fields_of(update));
}

}  // namespace knuckle
