// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/live_messages.h"

#include <string>

#include <fmt/format.h>

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
