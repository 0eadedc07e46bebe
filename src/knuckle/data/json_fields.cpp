// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/json_fields.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/suggestion.h"
#include "knuckle/core/text.h"

namespace knuckle {

void JsonValue::fail_expected(std::string_view what) const {
  fail("{}: expected {}, found {}", where, what,
       json.is_number() ? json.dump() : std::string(json.type_name()));
}

double JsonValue::number() const {
  if (!json.is_number()) fail_expected("a number");
  return json.get<double>();
}

double JsonValue::number(double low, double high) const {
  const double value = number();
  if (!(value >= low && value <= high)) fail("{}: is {}, expected {} to {}", where, value, low, high);
  return value;
}

double JsonValue::number_or_nan() const {
  return json.is_null() ? std::numeric_limits<double>::quiet_NaN() : number();
}

std::int64_t JsonValue::whole_number(std::int64_t low, std::int64_t high) const {
  if (!json.is_number_integer()) fail_expected("a whole number");
  const bool is_huge = json.is_number_unsigned() &&
                       json.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
  const auto value = json.get<std::int64_t>();
  if (is_huge || value < low || value > high)
    fail("{}: is {}, expected {} to {}", where, json.dump(), low, high);
  return value;
}

bool JsonValue::flag() const {
  if (!json.is_boolean()) fail_expected("true or false");
  return json.get<bool>();
}

std::string JsonValue::text(std::size_t most) const {
  if (!json.is_string()) fail_expected("a text");
  auto text = json.get<std::string>();
  if (text.size() > most) fail("{}: has {} bytes, expected {} at most", where, text.size(), most);
  return text;
}

std::size_t JsonValue::one_of(std::span<const std::string_view> names) const {
  const std::string name = text();
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) {
    fail("{}: is '{}', expected one of {}", where, name,
         joined(std::vector<std::string>(names.begin(), names.end())));
  }
  return static_cast<std::size_t>(found - names.begin());
}

JsonFields::JsonFields(const JsonValue& value, const std::vector<std::string>& known,
                       const std::vector<std::string>& optional)
    : value_(value) {
  if (!value_.json.is_object()) value_.fail_expected("an object");
  for (const auto& [key, field] : value_.json.items()) {
    if (std::ranges::find(known, key) != known.end() || std::ranges::find(optional, key) != optional.end())
      continue;
    std::vector<std::string> all = known;
    all.insert(all.end(), optional.begin(), optional.end());
    fail("{}: unknown key '{}'{}", value_.where, key, suggestion(key, all));
  }
  for (const std::string& key : known) require(key);
}

void JsonFields::require(const std::string& key) const {
  if (!has(key)) fail("{}: lacks the key '{}'", value_.where, key);
}

JsonValue JsonFields::at(const std::string& key) const {
  require(key);
  return {value_.json.at(key), fmt::format("{}: {}", value_.where, key)};
}

Json parsed_json(std::string_view text, std::size_t most_bytes, int deepest, std::string_view where) {
  if (text.size() > most_bytes) fail("{}: has {} bytes, expected {} at most", where, text.size(), most_bytes);
  const auto is_shallow = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth > deepest) throw std::length_error("it is nested too deeply");
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

}  // namespace knuckle
