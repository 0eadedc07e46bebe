// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_change.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/data/json_fields.h"
#include "knuckle/label/label_limits.h"

namespace knuckle {
namespace {

constexpr std::string_view kHeadBegins = R"({"knuckle_labels":)";
constexpr int kVersion = 1;
constexpr double kLongestWorkSeconds = 1e6;
constexpr std::array<std::string_view, 4> kStateNames{"estimated", "propagated", "corrected", "verified"};
constexpr std::array<std::string_view, 9> kActNames{"estimate", "propagate", "import", "correct", "look",
                                                    "verify",   "undo",      "redo",   "brush"};
constexpr std::size_t kPartsOfLabel = 5;  // state, whether it is visible, u, v, d

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

Camera camera_from(const JsonValue& value) {
  const JsonFields fields(value, {"model", "width", "height", "fx", "fy", "cx", "cy", "distortion"});
  constexpr std::array<std::string_view, 2> kModels{"projective", "orthographic"};
  const auto number = [&](const char* key) { return fields.at(key).number(-1e9, 1e9); };
  const auto side = [&](const char* key) {
    return static_cast<int>(fields.at(key).whole_number(1, limits::kImageSide));
  };
  Camera camera;
  camera.model =
      fields.at("model").one_of(kModels) == 0 ? CameraModel::projective : CameraModel::orthographic;
  camera.width = side("width");
  camera.height = side("height");
  camera.fx = number("fx");
  camera.fy = number("fy");
  camera.cx = number("cx");
  camera.cy = number("cy");
  const JsonValue distortion = fields.at("distortion");
  if (!distortion.json.is_array() || distortion.json.size() != camera.distortion.size())
    distortion.fail_expected("a list of 8 numbers");
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    camera.distortion[i] = JsonValue{distortion.json[i], distortion.where}.number(-1e9, 1e9);
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: {}", value.where, error.what());
  }
  return camera;
}

/// A convention is named with its landmarks, so that one that has changed since is noticed.
Convention convention_from(const JsonFields& fields, const JsonValue& landmarks) {
  const JsonValue name = fields.at("convention");
  const std::string text = name.text();
  Convention convention;
  try {
    convention = convention_from_name(text);
  } catch (const Error& error) {
    fail("{}: {}", name.where, error.what());
  }
  if (!landmarks.json.is_array() || landmarks.json.size() > limits::kJoints)
    landmarks.fail_expected("a list of landmarks");
  std::vector<std::string> names;
  for (const Json& one : landmarks.json) names.push_back(JsonValue{one, landmarks.where}.text());
  if (!std::ranges::equal(names, convention.landmarks, {}, {}, [](Landmark one) { return name_of(one); }))
    fail("{}: are not those of the convention {}", landmarks.where, text);
  return convention;
}

LandmarkLabel label_from(const JsonValue& value) {
  if (value.json.is_null()) return {};
  if (!value.json.is_array() || value.json.size() != kPartsOfLabel)
    value.fail_expected(R"(null or ["STATE", "visible" or "hidden", u, v, d])");
  const auto part = [&](std::size_t i) { return JsonValue{value.json[i], value.where}; };
  constexpr std::array<std::string_view, 2> kSeen{"hidden", "visible"};
  LandmarkLabel label;
  label.state = static_cast<LabelState>(part(0).one_of(kStateNames));
  label.is_visible = part(1).one_of(kSeen) == 1;
  label.at = {part(2).number(-kFarthestLabelPx, kFarthestLabelPx),
              part(3).number(-kFarthestLabelPx, kFarthestLabelPx),
              part(4).number(-kFarthestLabelMm, kFarthestLabelMm)};
  return label;
}

std::vector<LandmarkLabel> labels_from(const JsonValue& value, const Convention& convention) {
  if (!value.json.is_object()) value.fail_expected("an object");
  std::vector<LandmarkLabel> labels;
  for (const auto& [name, json] : value.json.items()) {
    if (labels.size() >= convention.landmarks.size() || name != name_of(convention.landmarks[labels.size()]))
      fail("{}: '{}' is not the next landmark of {}", value.where, name, convention.name);
    labels.push_back(label_from({json, fmt::format("{}.{}", value.where, name)}));
  }
  if (labels.size() != convention.landmarks.size())
    fail("{}: has {} landmarks, expected {}", value.where, labels.size(), convention.size());
  return labels;
}

/// [width, height, run, run, ...]
std::shared_ptr<const LabelMask> mask_from(const JsonValue& value) {
  constexpr std::size_t kSides = 2;
  if (!value.json.is_array() || value.json.size() <= kSides || value.json.size() > kSides + kMostMaskRuns)
    value.fail_expected(fmt::format("a list of width, height and 1 to {} runs", kMostMaskRuns));
  const auto number = [&](std::size_t i, std::int64_t low, std::int64_t high) {
    return JsonValue{value.json[i], value.where}.whole_number(low, high);
  };
  auto mask = std::make_shared<LabelMask>();
  mask->width = static_cast<int>(number(0, 1, limits::kImageSide));
  mask->height = static_cast<int>(number(1, 1, limits::kImageSide));
  const std::int64_t size = std::int64_t{mask->width} * mask->height;
  std::int64_t sum = 0;
  for (std::size_t i = kSides; i < value.json.size(); ++i) {
    mask->runs.push_back(number(i, 0, size - sum));
    sum += mask->runs.back();
  }
  if (sum != size) fail("{}: its runs have {} pixels, expected {}", value.where, sum, size);
  return mask;
}

void append_mask(const LabelMask& mask, std::string& line) {
  auto end = std::back_inserter(line);
  fmt::format_to(end, R"(,"mask":[{},{})", mask.width, mask.height);
  for (const std::int64_t run : mask.runs) fmt::format_to(end, ",{}", run);
  line += ']';
}

}  // namespace

std::string_view name_of(LabelState state) {
  return kStateNames[static_cast<std::size_t>(state)];
}

std::string_view name_of(LabelAct act) {
  return kActNames[static_cast<std::size_t>(act)];
}

bool is_of_person(LabelAct act) {
  return act == LabelAct::correct || act == LabelAct::look || act == LabelAct::verify ||
         act == LabelAct::brush;
}

bool says_mask(LabelAct act) {
  return act == LabelAct::brush || act == LabelAct::undo || act == LabelAct::redo;
}

bool has_landmarks(const LabelChange& change) {
  return std::ranges::any_of(change.landmarks,
                             [](const LandmarkLabel& label) { return !label.at.is_missing(); });
}

bool is_labelled(const LabelChange& change) {
  return change.mask != nullptr || has_landmarks(change);
}

bool LandmarkLabel::operator==(const LandmarkLabel& other) const {
  if (state != other.state || is_visible != other.is_visible || at.is_missing() != other.at.is_missing())
    return false;
  return at.is_missing() || (at.u == other.at.u && at.v == other.at.v && at.depth_mm == other.at.depth_mm);
}

std::string to_json_line(const LabelHead& head) {
  Json landmarks = Json::array();
  for (const Landmark landmark : head.convention.landmarks) landmarks.push_back(name_of(landmark));
  return text_of({{"knuckle_labels", kVersion},
                  {"source", head.source},
                  {"fingerprint", head.fingerprint},
                  {"frames", head.frames},
                  {"convention", head.convention.name},
                  {"landmarks", std::move(landmarks)},
                  {"camera", camera_json(head.camera)}});
}

std::string to_json_line(const LabelChange& change, const Convention& convention) {
  if (change.landmarks.size() != convention.landmarks.size())
    fail("a change has {} landmarks, the labels {}", change.landmarks.size(), convention.size());
  const Json others = {
      {"frame", change.frame},       {"side", change.side == HandSide::left ? "left" : "right"},
      {"revision", change.revision}, {"act", name_of(change.act)},
      {"author", change.author},     {"time", change.time}};
  std::string line = text_of(others);
  line.pop_back();
  auto end = std::back_inserter(line);
  fmt::format_to(end, R"(,"seconds":{:.1f},"landmarks":{{)", change.seconds);
  for (std::size_t i = 0; i < change.landmarks.size(); ++i) {
    const LandmarkLabel& label = change.landmarks[i];
    fmt::format_to(end, R"({}"{}":)", i == 0 ? "" : ",", name_of(convention.landmarks[i]));
    if (label.at.is_missing()) {
      line += "null";
      continue;
    }
    fmt::format_to(end, R"(["{}","{}",{:.4f},{:.4f},{:.4f}])", name_of(label.state),
                   label.is_visible ? "visible" : "hidden", label.at.u, label.at.v, label.at.depth_mm);
  }
  line += '}';
  if (change.mask && says_mask(change.act)) append_mask(*change.mask, line);
  return line + '}';
}

bool is_label_head(std::string_view line) {
  return line.starts_with(kHeadBegins);
}

LabelHead parse_label_head(std::string_view line, std::string_view where) {
  const Json json = parsed_json(line, limits::kLineLength, kDeepestLabelJson, where);
  const JsonFields fields({json, std::string(where)}, {"knuckle_labels", "source", "fingerprint", "frames",
                                                       "convention", "landmarks", "camera"});
  if (const JsonValue version = fields.at("knuckle_labels"); version.whole_number(0, 1 << 30) != kVersion)
    fail("{}: is {}, expected {}; a newer Knuckle may read it", version.where, version.json.dump(), kVersion);
  LabelHead head;
  head.source = fields.at("source").text(limits::kNameLength);
  head.fingerprint = fields.at("fingerprint").text();
  head.frames = fields.at("frames").whole_number(1, limits::kFrames);
  head.convention = convention_from(fields, fields.at("landmarks"));
  head.camera = camera_from(fields.at("camera"));
  return head;
}

LabelChange parse_label_change(std::string_view line, const LabelHead& head, std::string_view where) {
  const Json json = parsed_json(line, limits::kLineLength, kDeepestLabelJson, where);
  const JsonFields fields({json, std::string(where)},
                          {"frame", "side", "revision", "act", "author", "time", "seconds", "landmarks"},
                          {"mask"});
  constexpr std::array<std::string_view, 2> kSides{"right", "left"};
  LabelChange change;
  change.frame = fields.at("frame").whole_number(0, head.frames - 1);
  change.side = fields.at("side").one_of(kSides) == 1 ? HandSide::left : HandSide::right;
  change.revision = fields.at("revision").whole_number(1, std::numeric_limits<std::int64_t>::max());
  change.act = static_cast<LabelAct>(fields.at("act").one_of(kActNames));
  change.author = fields.at("author").text();
  change.time = fields.at("time").text();
  change.seconds = fields.at("seconds").number(0.0, kLongestWorkSeconds);
  change.landmarks = labels_from(fields.at("landmarks"), head.convention);
  if (!fields.has("mask")) return change;
  if (!says_mask(change.act)) fail("{}: a mask stands in a change that is none of it", where);
  change.mask = mask_from(fields.at("mask"));
  return change;
}

bool is_author_name(std::string_view name) {
  constexpr std::size_t kMost = 64;
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  return !name.empty() && name.size() <= kMost && name.front() != '.' && std::ranges::all_of(name, is_plain);
}

}  // namespace knuckle
