// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_request.h"

#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/data/json_fields.h"
#include "knuckle/label/label_limits.h"

namespace knuckle {
namespace {

using Kind = LabelRequest::Kind;

constexpr double kLongestSeconds = 3600.0;
constexpr std::array<std::string_view, 9> kActs{"place", "move", "look",  "free",   "verify",
                                                "undo",  "redo", "brush", "outline"};
const char* const kWhere = "message";

/// The keys that a kind needs.
std::vector<std::string> keys_of(Kind kind) {
  if (kind == Kind::undo || kind == Kind::redo) return {"act"};
  std::vector<std::string> keys{"act", "frame", "side", "revision"};
  if (kind == Kind::brush) keys.insert(keys.end(), {"points", "radius_px", "erases"});
  if (kind == Kind::brush || kind == Kind::outline) return keys;
  if (kind != Kind::verify) keys.emplace_back("landmark");
  if (kind == Kind::place) keys.emplace_back("pixel");
  if (kind == Kind::move) keys.emplace_back("point_mm");
  if (kind == Kind::look) keys.emplace_back("visible");
  return keys;
}

double number_in(const JsonValue& list, std::size_t size, std::size_t i, double farthest) {
  if (!list.json.is_array() || list.json.size() != size)
    list.fail_expected(fmt::format("a list of {} numbers", size));
  return JsonValue{list.json[i], list.where}.number(-farthest, farthest);
}

std::size_t landmark_from(const JsonValue& value, const Convention& convention) {
  const std::string name = value.text();
  for (std::size_t i = 0; i < convention.landmarks.size(); ++i) {
    if (name_of(convention.landmarks[i]) == name) return i;
  }
  fail("{}: '{}' is no landmark of {}", value.where, name, convention.name);
}

BrushStroke stroke_from(const JsonFields& fields) {
  const JsonValue points = fields.at("points");
  if (!points.json.is_array() || points.json.empty() || points.json.size() > kMostStrokePoints)
    points.fail_expected(fmt::format("a list of 1 to {} points", kMostStrokePoints));
  BrushStroke stroke;
  for (const Json& one : points.json) {
    const JsonValue point{one, points.where};
    stroke.points.push_back(
        {number_in(point, 2, 0, kFarthestLabelPx), number_in(point, 2, 1, kFarthestLabelPx)});
  }
  stroke.radius_px = fields.at("radius_px").number(kSmallestBrushPx, kLargestBrushPx);
  stroke.erases = fields.at("erases").flag();
  return stroke;
}

void read_hand(const JsonFields& fields, const LabelHead& head, LabelRequest& request) {
  constexpr std::array<std::string_view, 2> kSides{"right", "left"};
  request.hand.frame = fields.at("frame").whole_number(0, head.frames - 1);
  request.hand.side = fields.at("side").one_of(kSides) == 1 ? HandSide::left : HandSide::right;
  request.revision = fields.at("revision").whole_number(0, std::numeric_limits<std::int64_t>::max());
  if (fields.has("landmark")) request.landmark = landmark_from(fields.at("landmark"), head.convention);
}

}  // namespace

LabelRequest parse_label_request(std::string_view text, const LabelHead& head) {
  const Json json = parsed_json(text, kMostRequestBytes, kDeepestLabelJson, kWhere);
  const JsonValue message{json, kWhere};
  if (!json.is_object() || !json.contains("act")) message.fail_expected(R"(an object with the key "act")");
  LabelRequest request;
  request.kind = static_cast<Kind>(JsonValue{json["act"], "message: act"}.one_of(kActs));
  const JsonFields fields(message, keys_of(request.kind), {"preview", "model", "seconds"});
  if (fields.has("frame")) read_hand(fields, head, request);
  if (fields.has("pixel")) {
    request.u = number_in(fields.at("pixel"), 2, 0, kFarthestLabelPx);
    request.v = number_in(fields.at("pixel"), 2, 1, kFarthestLabelPx);
  }
  if (fields.has("point_mm")) {
    for (int i = 0; i < 3; ++i) {
      request.point_mm[i] =
          number_in(fields.at("point_mm"), 3, static_cast<std::size_t>(i), kFarthestLabelMm);
    }
  }
  if (fields.has("points")) request.stroke = stroke_from(fields);
  if (fields.has("visible")) request.is_visible = fields.at("visible").flag();
  if (fields.has("preview")) request.is_preview = fields.at("preview").flag();
  if (fields.has("model")) request.uses_model = fields.at("model").flag();
  if (fields.has("seconds")) request.seconds = fields.at("seconds").number(0.0, kLongestSeconds);
  return request;
}

}  // namespace knuckle
