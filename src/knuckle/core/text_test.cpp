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

TEST(TextTest, LowerCaseIsThatOfTheAlphabetAlone) {
  EXPECT_EQ(lower_case("AZaz @[ \xC3\x84 09_"), "azaz @[ \xC3\x84 09_");
  EXPECT_EQ(lower_case(""), "");
}

TEST(TextTest, SplitKeepsEmptyParts) {
  EXPECT_THAT(split("a,,b,", ','), ElementsAre("a", "", "b", ""));
  EXPECT_THAT(split("", ','), ElementsAre(""));
}

TEST(TextTest, TrimmedLosesBlanksAtBothEndsOnly) {
  EXPECT_EQ(trimmed(" \t a b \r\n"), "a b");
  EXPECT_EQ(trimmed("  "), "");
}

TEST(TextTest, PrintableEscapesWhatATerminalWouldTakeForACommand) {
  EXPECT_EQ(printable("knuckle \xC3\xA4 \xE2\x82\xAC \xF0\x9F\x96\x90"),
            "knuckle \xC3\xA4 \xE2\x82\xAC \xF0\x9F\x96\x90");
  EXPECT_EQ(printable("a\nb\tc\x1b[2J\x7f\r"), "a\\nb\\tc\\x1b[2J\\x7f\\x0d");
  EXPECT_EQ(printable(std::string_view("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("\xC2\x9B"
                      "31m"),
            "\\u{9b}31m")
      << "a control sequence in one character";
  EXPECT_EQ(printable("\xE2\x80\xAE"
                      "gnp"),
            "\\u{202e}gnp")
      << "turns the direction of writing";
}

TEST(TextTest, PrintableEscapesCharactersThatNobodySees) {
  EXPECT_EQ(printable("\xEE\x80\x80"), "\\u{e000}") << "of private use";
  EXPECT_EQ(printable("\xCD\xB8"), "\\u{378}") << "not assigned";
  EXPECT_EQ(printable("\xE2\x80\x8B"), "\\u{200b}") << "a blank without width";
  EXPECT_EQ(printable("\xEF\xBB\xBF"), "\\u{feff}") << "the mark of a byte order";
  EXPECT_EQ(printable("\xF3\xA0\x81\x81"), "\\u{e0041}") << "a tag";
}

TEST(TextTest, PrintableEscapesBytesThatAreNoUtf8) {
  EXPECT_EQ(printable("\xff\xfe"), "\\xff\\xfe");
  EXPECT_EQ(printable("\xC3"), "\\xc3") << "cut short";
  EXPECT_EQ(printable("\xC0\xAF"), "\\xc0\\xaf") << "longer than it need be";
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80") << "half of a pair of UTF-16";
  EXPECT_EQ(printable("\xF4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80") << "beyond Unicode";
}

TEST(Shortened, KeepsBeginningAndEnd) {
  EXPECT_EQ(shortened("0123456789", 10), "0123456789");
  EXPECT_EQ(shortened("0123456789A", 10), "012...89A");
  EXPECT_EQ(shortened("", 8), "");
}

TEST(Shortened, KeepsCharactersWhole) {
  std::string wide;
  for (int i = 0; i < 40; ++i) wide += "\u20ac";  // three bytes each
  for (std::size_t most = 9; most < 60; ++most) {
    const std::string text = shortened(wide, most);
    EXPECT_LE(text.size(), most);
    EXPECT_EQ(printable(text), text) << most;
  }
}

TEST(MessageLine, IsPrintableAndShort) {
  EXPECT_EQ(message_line("a\nb\x1b"), "a\\nb\\x1b");
  const std::string line = message_line("first" + std::string(14'000'000, 'x') + "last");
  EXPECT_EQ(line.size(), 4095);
  EXPECT_THAT(line, ::testing::AllOf(::testing::StartsWith("firstx"), ::testing::EndsWith("xlast")));
}

TEST(ParseNumber, QuotesWhatCanBeShown) {
  EXPECT_THAT(testing::error_of([] { parse_number(std::string_view("4\0z", 3), "a.txt:1"); }),
              ::testing::HasSubstr("found '4\\x00z'"));
}

TEST(Error, SaysAllThatStandsAfterAZero) {
  using std::string_literals::operator""s;
  EXPECT_EQ(testing::error_of([] { fail("{}: not a name", "a\0b\0"s); }), "a\\x00b\\x00: not a name");
}

}  // namespace
}  // namespace knuckle
