// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;

TEST(TextTest, NumbersMayBePartedByBlanksOrSeparators) {
  EXPECT_THAT(parse_numbers(" 1 2.5\t-3e2, +4;5 , ", "x"), ElementsAre(1.0, 2.5, -300.0, 4.0, 5.0));
  EXPECT_TRUE(parse_numbers("  \r\n", "x").empty());
}

TEST(TextTest, NanIsANumberInAnyCase) {
  for (const double value : parse_numbers("nan NaN NAN", "x")) EXPECT_TRUE(std::isnan(value));
}

TEST(TextTest, AWordIsNoNumberAndTheMessageTellsWhere) {
  const std::string message = error_of([] { parse_numbers("1 2 x3", "joints.txt:7"); });
  EXPECT_THAT(message, HasSubstr("joints.txt:7"));
  EXPECT_THAT(message, HasSubstr("'x3'"));
}

TEST(TextTest, HalfANumberIsNone) {
  EXPECT_THAT(error_of([] { parse_number("1.5mm", "f"); }), HasSubstr("expected a number"));
  EXPECT_THAT(error_of([] { parse_number("", "f"); }), HasSubstr("expected a number"));
  EXPECT_THAT(error_of([] { parse_number("+-1", "f"); }), HasSubstr("expected a number"));
  EXPECT_THAT(error_of([] { parse_integer("1.5", "f"); }), HasSubstr("expected a whole number"));
  EXPECT_THAT(error_of([] { parse_integer("99999999999999999999", "f"); }), HasSubstr("out of range"));
}

TEST(TextTest, SplitKeepsEmptyParts) {
  EXPECT_THAT(split("a,,b,", ','), ElementsAre("a", "", "b", ""));
  EXPECT_THAT(split("", ','), ElementsAre(""));
}

TEST(TextTest, TrimmedLosesBlanksAtBothEndsOnly) {
  EXPECT_EQ(trimmed(" \t a b \r\n"), "a b");
  EXPECT_EQ(trimmed("  "), "");
}

}  // namespace
}  // namespace knuckle
