// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/live_messages.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include <nlohmann/json.hpp>

#include "knuckle/core/landmarks.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/hand/hand_flesh.h"
#include "knuckle/hand/landmark_definition.h"

namespace knuckle {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "messages are little endian, and copied");

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// The keys of a folder set's [camera]; pixel coordinates start at the centre of the first pixel.
Json camera_json(const Camera& camera) {
  return {{"model", camera.model == CameraModel::orthographic ? "orthographic" : "projective"},
          {"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", camera.distortion}};
}

Json recording_json(const RecordingState& recording) {
  Json json = {{"file", nullptr},
               {"frames", recording.frames},
               {"dropped", recording.dropped},
               {"fault", recording.fault}};
  if (!recording.file.empty()) json["file"] = recording.file;
  return json;
}

Json landmarks_json(const Convention& convention) {
  Json names = Json::array();
  for (const Landmark landmark : convention.landmarks) names.push_back(name_of(landmark));
  return names;
}

Json bones_json(const Convention& convention) {
  const auto name = [&](int index) { return name_of(convention.landmarks[static_cast<std::size_t>(index)]); };
  Json bones = Json::array();
  for (const Bone& bone : skeleton_of(convention)) bones.push_back({name(bone.from), name(bone.to)});
  return bones;
}

double rounded(double value) {
  constexpr double kPerMillimetre = 1000.0;
  return std::round(value * kPerMillimetre) / kPerMillimetre;
}

/// A list per hand, of pieces of eight numbers.
Json surface_json(const FrameRecord& record) {
  Json hands = Json::array();
  for (const HandRecord& hand : record.hands) {
    Json pieces = Json::array();
    for (FleshPiece piece : flesh_of(hand)) {
      std::ranges::transform(piece, piece.begin(), rounded);
      pieces.push_back(piece);
    }
    hands.push_back(std::move(pieces));
  }
  return hands;
}

bool has_infrared(const Frame& frame) {
  return !frame.infrared.empty() && frame.infrared.width() == frame.depth_mm.width() &&
         frame.infrared.height() == frame.depth_mm.height();
}

std::string header_of(const LiveUpdate& update, double depth_unit_mm) {
  const Frame& frame = *update.frame;
  const Json others = {{"camera", camera_json(frame.camera)},
                       {"width", frame.depth_mm.width()},
                       {"height", frame.depth_mm.height()},
                       {"depth_unit_mm", depth_unit_mm},
                       {"infrared", has_infrared(frame)},
                       {"surface", surface_json(update.record)},
                       {"recording", recording_json(update.recording)},
                       {"arrived", update.arrived},
                       {"passed_over", update.passed_over}};
  std::string header = R"({"record":)" + to_json_line(update.record) + "," + text_of(others).substr(1);
  constexpr std::size_t kAlignment = 4;
  header.resize((header.size() + kAlignment - 1) / kAlignment * kAlignment, ' ');
  return header;
}

std::uint8_t* copied_to(std::uint8_t* to, const void* from, std::size_t size) {
  if (size > 0) std::memcpy(to, from, size);
  return to + size;
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
  const Frame& frame = *update.frame;
  const double unit_mm = suitable_depth_unit_mm(frame.depth_mm);
  const std::string header = header_of(update, unit_mm);
  const Image<std::uint16_t> depth = near_counts_from_depth(frame.depth_mm, unit_mm);
  const auto header_size = static_cast<std::uint32_t>(header.size());
  const std::size_t infrared_size = has_infrared(frame) ? frame.infrared.pixels().size_bytes() : 0;
  std::vector<std::uint8_t> message(sizeof(header_size) + header.size() + depth.pixels().size_bytes() +
                                    infrared_size);
  std::uint8_t* end = copied_to(message.data(), &header_size, sizeof(header_size));
  end = copied_to(end, header.data(), header.size());
  end = copied_to(end, depth.data(), depth.pixels().size_bytes());
  copied_to(end, frame.infrared.data(), infrared_size);
  return message;
}

}  // namespace knuckle
