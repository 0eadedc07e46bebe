// SPDX-License-Identifier: Apache-2.0
// Reads JSON of people and files that may be wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace knuckle {

using Json = nlohmann::ordered_json;

/// A value, and where it stands, for messages: "records.jsonl:12: hands[0]: score". Each member throws an
/// Error where the value is no such thing.
struct JsonValue {
  const Json& json;
  std::string where;

  double number() const;
  /// In [low, high].
  double number(double low, double high) const;
  /// NaN where it is null.
  double number_or_nan() const;
  /// In [low, high].
  std::int64_t whole_number(std::int64_t low, std::int64_t high) const;
  bool flag() const;
  /// Of at most `most` bytes.
  std::string text(std::size_t most = kMostTextBytes) const;
  /// The place of the text in a list of names.
  std::size_t one_of(std::span<const std::string_view> names) const;

  [[noreturn]] void fail_expected(std::string_view what) const;

  static constexpr std::size_t kMostTextBytes = 256;
};

/// The fields of an object: all of `known`, maybe some of `optional`, and no others; an Error says what is
/// unknown or lacks.
class JsonFields {
 public:
  JsonFields(const JsonValue& value, const std::vector<std::string>& known,
             const std::vector<std::string>& optional = {});

  bool has(const std::string& key) const { return value_.json.contains(key); }
  /// Throws an Error where it lacks.
  JsonValue at(const std::string& key) const;

 private:
  void require(const std::string& key) const;

  JsonValue value_;
};

/// A text as JSON. Throws an Error where it is none, longer than `most_bytes`, or nested deeper than
/// `deepest`, before that costs anything.
Json parsed_json(std::string_view text, std::size_t most_bytes, int deepest, std::string_view where);

}  // namespace knuckle
