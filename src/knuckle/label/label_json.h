// SPDX-License-Identifier: Apache-2.0
// Reads JSON of people and files that may be wrong; for the sources of this module alone.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"

namespace knuckle::label_json {

using Json = nlohmann::ordered_json;

inline constexpr std::size_t kMostNameBytes = 256;  ///< of names of any kind
/// What lies outside of the image may be labelled, within reason.
inline constexpr double kFarthestPx = 1e5;
inline constexpr double kFarthestMm = 1e6;  ///< from the camera

/// A value, and where it stands, for messages.
struct Value {
  const Json& json;
  std::string where;

  [[noreturn]] void fail_expected(std::string_view what) const {
    fail("{}: expected {}, found {}", where, what,
         json.is_number() ? json.dump() : std::string(json.type_name()));
  }
  double number(double low, double high) const {
    if (!json.is_number()) fail_expected("a number");
    const auto value = json.get<double>();
    if (!(value >= low && value <= high)) fail("{}: is {}, expected {} to {}", where, value, low, high);
    return value;
  }
  std::int64_t whole_number(std::int64_t low, std::int64_t high) const {
    if (!json.is_number_integer()) fail_expected("a whole number");
    const bool is_huge = json.is_number_unsigned() &&
                         json.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
    const auto value = is_huge ? std::int64_t{-1} : json.get<std::int64_t>();
    if (is_huge || value < low || value > high)
      fail("{}: is {}, expected {} to {}", where, json.dump(), low, high);
    return value;
  }
  bool flag() const {
    if (!json.is_boolean()) fail_expected("true or false");
    return json.get<bool>();
  }
  std::string text(std::size_t most = kMostNameBytes) const {
    if (!json.is_string()) fail_expected("a text");
    auto text = json.get<std::string>();
    if (text.size() > most) fail("{}: has {} bytes, expected {} at most", where, text.size(), most);
    return text;
  }
  /// The place of the text in a list of names.
  template <std::size_t Size>
  std::size_t one_of(const std::array<std::string_view, Size>& names) const {
    const std::string name = text();
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
      fail("{}: is '{}', expected one of {}", where, name,
           joined(std::vector<std::string>(names.begin(), names.end())));
    }
    return static_cast<std::size_t>(found - names.begin());
  }
};

/// The fields of an object: all of `known`, maybe some of `optional`, and no others.
class Fields {
 public:
  Fields(const Value& value, const std::vector<std::string>& known,
         const std::vector<std::string>& optional = {})
      : value_(value) {
    if (!value_.json.is_object()) value_.fail_expected("an object");
    for (const auto& [key, field] : value_.json.items()) {
      const bool is_known =
          std::ranges::find(known, key) != known.end() || std::ranges::find(optional, key) != optional.end();
      if (!is_known) fail("{}: unknown key '{}'{}", value_.where, key, suggestion(key, known));
    }
    for (const std::string& key : known) {
      if (!has(key)) fail("{}: lacks the key '{}'", value_.where, key);
    }
  }
  bool has(const std::string& key) const { return value_.json.contains(key); }
  Value at(const std::string& key) const {
    return {value_.json.at(key), fmt::format("{}: {}", value_.where, key)};
  }

 private:
  Value value_;
};

/// A text as JSON. What is nested deeper than messages are is refused before that costs anything.
inline Json parsed(std::string_view text, std::size_t most_bytes, std::string_view where) {
  if (text.size() > most_bytes) fail("{}: has {} bytes, expected {} at most", where, text.size(), most_bytes);
  constexpr int kDeepest = 4;
  const auto is_shallow = [](int depth, Json::parse_event_t, const Json&) {
    if (depth > kDeepest) throw std::length_error("it is nested too deeply");
    return true;
  };
  try {
    return Json::parse(text, is_shallow);
  } catch (const std::exception& error) {
    std::string_view message = error.what();  // "[json.exception.parse_error.101] parse error at ..."
    if (const std::size_t end = message.find("] "); end != std::string_view::npos)
      message.remove_prefix(end + 2);
    fail("{}: not JSON: {}", where, message);
  }
}

}  // namespace knuckle::label_json
