// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/json_fields.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::HasSubstr;

constexpr std::size_t kMostBytes = 1000;
constexpr int kDeepest = 3;

Json json_of(std::string_view text) {
  return parsed_json(text, kMostBytes, kDeepest, "a:3");
}

/// What a reading of the JSON says is wrong.
template <class Read>
std::string fault(std::string_view text, const Read& read) {
  const Json json = json_of(text);
  return testing::error_of([&] { (void)read(JsonValue{json, "a:3"}); });
}

TEST(JsonValue, NumbersAreReadWithinTheirBounds) {
  const Json json = json_of("[-2.5, 7, null, 18446744073709551615, 9223372036854775807, 1e300]");
  const auto value = [&](std::size_t i) { return JsonValue{json[i], "v"}; };
  EXPECT_EQ(value(0).number(-2.5, 1.0), -2.5);
  EXPECT_EQ(value(0).number(-3.0, -2.5), -2.5);
  EXPECT_EQ(value(5).number(), 1e300);
  EXPECT_EQ(value(1).number_or_nan(), 7.0);
  EXPECT_TRUE(std::isnan(value(2).number_or_nan()));
  EXPECT_EQ(value(1).whole_number(7, 7), 7);
  EXPECT_EQ(value(4).whole_number(0, std::numeric_limits<std::int64_t>::max()),
            std::numeric_limits<std::int64_t>::max());
  const auto bounded = [](const JsonValue& one) { return one.number(1.0, 2.0); };
  EXPECT_EQ(fault("2.5", bounded), "a:3: is 2.5, expected 1 to 2");
  EXPECT_EQ(fault("0.5", bounded), "a:3: is 0.5, expected 1 to 2");
  EXPECT_EQ(fault("\"2\"", bounded), "a:3: expected a number, found string");
  EXPECT_EQ(fault("null", bounded), "a:3: expected a number, found null");
  const auto whole = [](const JsonValue& one) { return one.whole_number(-3, 4); };
  EXPECT_EQ(fault("5", whole), "a:3: is 5, expected -3 to 4");
  EXPECT_EQ(fault("-4", whole), "a:3: is -4, expected -3 to 4");
  EXPECT_EQ(fault("2.0", whole), "a:3: expected a whole number, found 2.0");
  EXPECT_EQ(fault("18446744073709551615", whole), "a:3: is 18446744073709551615, expected -3 to 4")
      << "more than a signed number holds, and -1 where only its bits are looked at";
}

TEST(JsonValue, FlagsTextsAndNamesAreNothingElse) {
  constexpr std::array<std::string_view, 2> kNames{"left", "right"};
  const Json json = json_of(R"([true, "right", ""])");
  EXPECT_TRUE((JsonValue{json[0], "v"}.flag()));
  EXPECT_EQ((JsonValue{json[1], "v"}.text(5)), "right");
  EXPECT_EQ((JsonValue{json[2], "v"}.text(0)), "");
  EXPECT_EQ((JsonValue{json[1], "v"}.one_of(kNames)), 1U);
  EXPECT_EQ(fault("1", [](const JsonValue& one) { return one.flag(); }),
            "a:3: expected true or false, found 1");
  EXPECT_EQ(fault("[]", [](const JsonValue& one) { return one.text(); }),
            "a:3: expected a text, found array");
  EXPECT_EQ(fault("\"right\"", [](const JsonValue& one) { return one.text(4); }),
            "a:3: has 5 bytes, expected 4 at most");
  EXPECT_EQ(fault("\"up\"", [&](const JsonValue& one) { return one.one_of(kNames); }),
            "a:3: is 'up', expected one of left, right");
}

TEST(JsonFields, WhatIsUnknownOrLacksIsNamed) {
  const auto fields_of = [](const JsonValue& value) {
    return JsonFields(value, {"frame", "name"}, {"side"});
  };
  const Json json = json_of(R"({"name": "n", "frame": 4, "side": null})");
  const JsonFields fields = fields_of({json, "a:3"});
  EXPECT_EQ(fields.at("frame").whole_number(0, 9), 4);
  EXPECT_EQ(fields.at("name").where, "a:3: name");
  EXPECT_TRUE(fields.has("side"));
  EXPECT_EQ(fault(R"({"frame": 4})", fields_of), "a:3: lacks the key 'name'");
  EXPECT_EQ(fault(R"({"frame": 4, "name": "", "sid": 1})", fields_of),
            "a:3: unknown key 'sid' (did you mean 'side'?)");
  EXPECT_EQ(fault("[4]", fields_of), "a:3: expected an object, found array");
  EXPECT_EQ(
      fault(R"({"frame": 4, "name": ""})", [&](const JsonValue& one) { return fields_of(one).at("side"); }),
      "a:3: lacks the key 'side'");
}

TEST(ParsedJson, RefusesWhatIsNoneTooLongOrTooDeep) {
  EXPECT_EQ(json_of("[[[1]]]")[0][0][0], 1);
  EXPECT_EQ(testing::error_of([] { json_of("[[[[1]]]]"); }), "a:3: not JSON: it is nested too deeply");
  EXPECT_THAT(testing::error_of([] { json_of(std::string(kMostBytes, '[')); }), HasSubstr("too deeply"));
  EXPECT_THAT(testing::error_of([] { json_of("{\"a\""); }),
              HasSubstr("a:3: not JSON: parse error at line 1"));
  EXPECT_THAT(testing::error_of([] { json_of(""); }), HasSubstr("a:3: not JSON: "));
  EXPECT_THAT(testing::error_of([] { json_of("[1e999]"); }), HasSubstr("a:3: not JSON: "));
  EXPECT_EQ(json_of(std::string(kMostBytes - 1, ' ') + "7"), 7);
  EXPECT_EQ(testing::error_of([] { json_of(std::string(kMostBytes, ' ') + "7"); }),
            "a:3: has 1001 bytes, expected 1000 at most");
}

}  // namespace
}  // namespace knuckle
