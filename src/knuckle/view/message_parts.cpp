// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/message_parts.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "knuckle/data/fitted_flesh.h"
#include "knuckle/data/readers/depth_image.h"

namespace knuckle {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are little endian, and copied");

double rounded_mm(double value) {
  constexpr double kPerMillimetre = 1000.0;
  return std::round(value * kPerMillimetre) / kPerMillimetre;
}

bool has_infrared(const Frame& frame) {
  return !frame.infrared.empty() && frame.infrared.width() == frame.depth_mm.width() &&
         frame.infrared.height() == frame.depth_mm.height();
}

std::string header_of(const Frame& frame, std::string_view fields, double depth_unit_mm) {
  const Json others = {{"camera", camera_json(frame.camera)},
                       {"width", frame.depth_mm.width()},
                       {"height", frame.depth_mm.height()},
                       {"depth_unit_mm", depth_unit_mm},
                       {"infrared", has_infrared(frame)}};
  std::string header = fmt::format("{{{},{}", fields, text_of(others).substr(1));
  constexpr std::size_t kAlignment = 4;
  header.resize((header.size() + kAlignment - 1) / kAlignment * kAlignment, ' ');
  return header;
}

std::uint8_t* copied_to(std::uint8_t* to, const void* from, std::size_t size) {
  if (size > 0) std::memcpy(to, from, size);
  return to + size;
}

}  // namespace

std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

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

Json flesh_json(const HandRecord& hand) {
  Json pieces = Json::array();
  for (const FleshCone& cone : fitted_flesh(hand)) {
    std::array<double, 8> piece{cone.from.x(), cone.from.y(), cone.from.z(), cone.radius_from,
                                cone.to.x(),   cone.to.y(),   cone.to.z(),   cone.radius_to};
    std::ranges::transform(piece, piece.begin(), rounded_mm);
    pieces.push_back(piece);
  }
  return pieces;
}

std::vector<std::uint8_t> image_message(const Frame& frame, std::string_view fields) {
  const double unit_mm = suitable_depth_unit_mm(frame.depth_mm);
  const std::string header = header_of(frame, fields, unit_mm);
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
