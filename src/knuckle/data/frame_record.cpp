// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/frame_record.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/text.h"
#include "knuckle/data/json_fields.h"

namespace knuckle {
namespace {

using Line = fmt::memory_buffer;

constexpr int kTimeDigits = 6;  // [s]
constexpr int kLengthDigits = 3;
constexpr int kShareDigits = 4;
constexpr int kAngleDigits = 5;
constexpr int kDeepest = 8;  // brackets in one another, more than records have
constexpr std::size_t kMostBytes = limits::kLineLength;

void append(Line& line, std::string_view text) {
  line.append(text);
}

void append_number(Line& line, double value, int digits) {
  if (!std::isfinite(value)) return append(line, "null");
  const std::size_t start = line.size();
  fmt::format_to(std::back_inserter(line), "{:.{}f}", value, digits);
  const std::string_view written(line.data() + start, line.size() - start);
  const bool is_minus_zero =
      written.starts_with('-') && written.find_first_not_of("-0.") == std::string_view::npos;
  if (is_minus_zero) {
    std::copy(line.data() + start + 1, line.data() + line.size(), line.data() + start);
    line.resize(line.size() - 1);
  }
}

void append_text(Line& line, const std::string& text) {
  append(line, Json(text).dump(-1, ' ', false, Json::error_handler_t::replace));
}

/// `,"key":`, without the comma after an opening bracket.
void append_key(Line& line, std::string_view key) {
  if (line[line.size() - 1] != '{') line.push_back(',');
  fmt::format_to(std::back_inserter(line), "\"{}\":", key);
}

/// A list of lengths, or null where one is not finite.
void append_lengths(Line& line, std::initializer_list<double> lengths) {
  if (!std::ranges::all_of(lengths, [](double length) { return std::isfinite(length); }))
    return append(line, "null");
  char bracket = '[';
  for (const double length : lengths) {
    line.push_back(std::exchange(bracket, ','));
    append_number(line, length, kLengthDigits);
  }
  line.push_back(']');
}

template <class Values, class AppendValue>
void append_landmarks(Line& line, std::string_view key, const Convention& convention, const Values& values,
                      const AppendValue& append_value) {
  append_key(line, key);
  line.push_back('{');
  for (std::size_t i = 0; i < values.size(); ++i) {
    append_key(line, name_of(convention.landmarks[i]));
    append_value(line, values[i]);
  }
  line.push_back('}');
}

std::string_view name_of_side(const std::optional<HandSide>& side) {
  if (!side) return "null";
  return *side == HandSide::left ? "\"left\"" : "\"right\"";
}

void require_landmarks(const HandRecord& hand) {
  const std::size_t count = hand.convention.landmarks.size();
  if (hand.landmarks_mm.size() != count || hand.landmarks_px.size() != count ||
      (!hand.confidence.empty() && hand.confidence.size() != count)) {
    fail("a hand's record has {} landmarks in mm, {} in px and {} confidences, expected {} of {}",
         hand.landmarks_mm.size(), hand.landmarks_px.size(), hand.confidence.size(), count,
         hand.convention.name);
  }
}

void append_hand(Line& line, const HandRecord& hand) {
  require_landmarks(hand);
  const auto append_mm = [](Line& to, const Point3& point) {
    append_lengths(to, {point.x(), point.y(), point.z()});
  };
  const auto append_px = [](Line& to, const PixelPoint& point) { append_lengths(to, {point.u, point.v}); };
  const auto append_share = [](Line& to, double value) { append_number(to, value, kShareDigits); };
  fmt::format_to(std::back_inserter(line), "{{\"id\":{},\"side\":{},\"score\":", hand.id,
                 name_of_side(hand.side));
  append_share(line, hand.score);
  append_landmarks(line, "landmarks_mm", hand.convention, hand.landmarks_mm, append_mm);
  append_landmarks(line, "landmarks_px", hand.convention, hand.landmarks_px, append_px);
  append_landmarks(line, "confidence", hand.convention, hand.confidence, append_share);
  if (!hand.angles_rad.empty()) {
    append(line, ",\"angles_rad\":{");
    for (const auto& [name, angle] : hand.angles_rad) {
      append_key(line, name);
      append_number(line, angle, kAngleDigits);
    }
    line.push_back('}');
  }
  if (!hand.skeleton.empty()) {
    append_key(line, "skeleton");
    append_text(line, hand.skeleton);
  }
  line.push_back('}');
}

// --- reading ---

/// Calls `visit(name, value)` for the entries of an object whose keys are names of something.
template <class Visit>
void for_entries(const JsonValue& object, const Visit& visit) {
  if (!object.json.is_object()) object.fail_expected("an object");
  for (const auto& [name, json] : object.json.items())
    visit(name, JsonValue{json, fmt::format("{}.{}", object.where, name)});
}

/// A list of `count` numbers; as many NaN where it is null.
std::vector<double> numbers_or_nan(const JsonValue& value, std::size_t count) {
  std::vector<double> numbers(count, kNaN);
  if (value.json.is_null()) return numbers;
  if (!value.json.is_array() || value.json.size() != count)
    fail("{}: expected a list of {} numbers or null", value.where, count);
  for (std::size_t i = 0; i < count; ++i) numbers[i] = JsonValue{value.json[i], value.where}.number();
  return numbers;
}

Point3 point_from(const JsonValue& value) {
  const std::vector<double> xyz = numbers_or_nan(value, 3);
  return {xyz[0], xyz[1], xyz[2]};
}

PixelPoint pixel_from(const JsonValue& value) {
  const std::vector<double> uv = numbers_or_nan(value, 2);
  return {uv[0], uv[1]};
}

/// The convention whose landmarks are the keys, in its order.
Convention convention_of(const JsonValue& landmarks) {
  std::vector<std::string> names;
  for_entries(landmarks, [&](const std::string& name, const JsonValue&) { names.push_back(name); });
  std::vector<Convention> known = own_conventions();
  known.insert(known.begin(), conventions().begin(), conventions().end());
  for (const Convention& convention : known) {
    if (std::ranges::equal(convention.landmarks, names, {}, name_of)) return convention;
  }
  fail("{}: has the landmarks of no convention: {}", landmarks.where, joined(names));
}

/// One value per landmark of the convention.
template <class T, class Read>
std::vector<T> values_per_landmark(const JsonValue& object, const Convention& convention, const Read& read) {
  std::vector<T> values;
  for_entries(object, [&](const std::string& name, const JsonValue& value) {
    if (values.size() >= convention.landmarks.size() || name != name_of(convention.landmarks[values.size()]))
      fail("{}: is not the next landmark of {}", value.where, convention.name);
    values.push_back(read(value));
  });
  if (values.size() != convention.landmarks.size())
    fail("{}: has {} landmarks, expected {}", object.where, values.size(), convention.size());
  return values;
}

std::optional<HandSide> side_from(const JsonValue& value) {
  if (value.json.is_null()) return std::nullopt;
  const std::string side = value.text();
  if (side != "right" && side != "left") fail("{}: is '{}', expected right, left or null", value.where, side);
  return side == "left" ? HandSide::left : HandSide::right;
}

HandRecord hand_from(const JsonValue& value) {
  const JsonFields fields(value, {"id", "side", "score", "landmarks_mm", "landmarks_px", "confidence"},
                          {"angles_rad", "skeleton"});
  HandRecord hand;
  hand.id = static_cast<int>(fields.at("id").whole_number(1, std::numeric_limits<int>::max()));
  hand.side = side_from(fields.at("side"));
  hand.score = fields.at("score").number_or_nan();
  hand.convention = convention_of(fields.at("landmarks_mm"));
  hand.landmarks_mm = values_per_landmark<Point3>(fields.at("landmarks_mm"), hand.convention, point_from);
  hand.landmarks_px = values_per_landmark<PixelPoint>(fields.at("landmarks_px"), hand.convention, pixel_from);
  if (const JsonValue confidence = fields.at("confidence"); !confidence.json.empty()) {
    hand.confidence = values_per_landmark<double>(confidence, hand.convention,
                                                  [](const JsonValue& one) { return one.number_or_nan(); });
  }
  if (fields.has("angles_rad")) {
    for_entries(fields.at("angles_rad"), [&](const std::string& name, const JsonValue& angle) {
      hand.angles_rad.emplace_back(name, angle.number_or_nan());
    });
  }
  if (fields.has("skeleton")) hand.skeleton = fields.at("skeleton").text(kMostBytes);
  return hand;
}

std::optional<double> number_or_nothing(const JsonValue& value) {
  if (value.json.is_null()) return std::nullopt;
  return value.number();
}

}  // namespace

HandRecord hand_record(const HandPose& pose, const Projection& projection, PixelOrigin origin) {
  const double shift = origin == PixelOrigin::corner ? 0.5 : 0.0;
  HandRecord hand;
  hand.convention = pose.convention;
  for (const ImagePoint& joint : pose.joints) {
    const bool is_missing = joint.is_missing();
    hand.landmarks_mm.push_back(is_missing ? Point3::Constant(kNaN) : projection.to_camera(joint));
    hand.landmarks_px.push_back(is_missing ? PixelPoint{} : PixelPoint{joint.u + shift, joint.v + shift});
  }
  hand.confidence.assign(pose.confidence.begin(), pose.confidence.end());
  return hand;
}

std::string to_json_line(const FrameRecord& record) {
  Line line;
  fmt::format_to(std::back_inserter(line), "{{\"frame\":{},\"name\":", record.frame);
  append_text(line, record.name);
  append_key(line, "time_s");
  append_number(line, record.time_s.value_or(kNaN), kTimeDigits);
  append_key(line, "status");
  append_text(line, record.status);
  append_key(line, "hands");
  line.push_back('[');
  for (std::size_t i = 0; i < record.hands.size(); ++i) {
    if (i > 0) line.push_back(',');
    append_hand(line, record.hands[i]);
  }
  line.push_back(']');
  if (record.latency_ms) {
    append_key(line, "latency_ms");
    append_number(line, *record.latency_ms, kLengthDigits);
  }
  line.push_back('}');
  return fmt::to_string(line);
}

FrameRecord parse_frame_record(std::string_view line, std::string_view where) {
  const Json json = parsed_json(line, kMostBytes, kDeepest, where);
  const JsonFields fields({json, std::string(where)}, {"frame", "name", "time_s", "status", "hands"},
                          {"latency_ms"});
  FrameRecord record;
  record.frame = fields.at("frame").whole_number(0, std::numeric_limits<std::int64_t>::max());
  record.name = fields.at("name").text(kMostBytes);
  record.time_s = number_or_nothing(fields.at("time_s"));
  record.status = fields.at("status").text(kMostBytes);
  const JsonValue hands = fields.at("hands");
  if (!hands.json.is_array()) hands.fail_expected("a list");
  for (std::size_t i = 0; i < hands.json.size(); ++i)
    record.hands.push_back(hand_from({hands.json[i], fmt::format("{}[{}]", hands.where, i)}));
  if (fields.has("latency_ms")) record.latency_ms = number_or_nothing(fields.at("latency_ms"));
  return record;
}

}  // namespace knuckle
