// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/options.h"

#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::string_view kSides[] = {"left", "right"};

struct ExampleOptions {
  double bandwidth_mm = 13.5;
  int count = 3;
  std::uint64_t seed = 1;
  bool closes_gaps = false;
  std::string title = "none";
  std::string side = "right";
  std::vector<double> range_mm = {1.0, 2.0};
  std::vector<std::string> sides;

  void visit(OptionVisitor& visitor) {
    visitor.real("bandwidth_mm", bandwidth_mm, open_closed(0.0, 500.0));
    visitor.integer("count", count, closed(1, 10));
    visitor.seed("seed", seed);
    visitor.flag("closes_gaps", closes_gaps);
    visitor.text("title", title);
    visitor.choice("side", side, kSides);
    visitor.reals("range_mm", range_mm, at_least(0.0), 2, 2);
    visitor.texts("sides", sides, kSides);
  }
};

ExampleOptions read(std::string_view toml) {
  const OptionTable table = OptionTable::parse(toml, "example.toml");
  ExampleOptions options;
  table.read(options);
  table.finish();
  return options;
}

std::string fault(std::string_view toml) {
  return error_of([&] { read(toml); });
}

TEST(OptionsTest, KeysThatAreThereReplaceDefaults) {
  const ExampleOptions options =
      read("bandwidth_mm = 20\nside = 'left'\nrange_mm = [3, 4.5]\nsides = ['left']\n");
  EXPECT_EQ(options.bandwidth_mm, 20.0);
  EXPECT_EQ(options.side, "left");
  EXPECT_THAT(options.range_mm, ElementsAre(3.0, 4.5));
  EXPECT_THAT(options.sides, ElementsAre("left"));
  EXPECT_EQ(options.count, 3);
}

TEST(OptionsTest, AnUnknownKeyIsNamedWithItsLineAndTheKnownOnes) {
  const std::string message = fault("count = 2\nbandwith_mm = 3.0\n");
  EXPECT_THAT(message, StartsWith("example.toml:2: bandwith_mm: unknown key"));
  EXPECT_THAT(message, HasSubstr("did you mean 'bandwidth_mm'?"));
  EXPECT_THAT(message, HasSubstr("sides, title"));
}

TEST(OptionsTest, AMistypedKeyIsNamedBeforeTheOneThatIsMissing) {
  const OptionTable table = OptionTable::parse("x = 1\n\nmodle = 'm'", "f");
  EXPECT_THAT(error_of([&] { table.required_text("model"); }),
              StartsWith("f:3: modle: unknown key (did you mean 'model'?)"));
  EXPECT_THAT(error_of([&] { table.required_text("method"); }), StartsWith("f:1: method: is missing"));
}

TEST(OptionsTest, AMistypedChoiceGetsASuggestion) {
  EXPECT_THAT(fault("side = 'rihgt'"), HasSubstr("is \"rihgt\" (did you mean 'right'?), expected one of"));
}

TEST(OptionsTest, AWrongTypeIsNamedWithItsLine) {
  EXPECT_THAT(fault("\nbandwidth_mm = 'wide'"),
              StartsWith("example.toml:2: bandwidth_mm: expected a number"));
  EXPECT_THAT(fault("count = 1.5"), HasSubstr("count: expected a whole number, found a number"));
  EXPECT_THAT(fault("closes_gaps = 1"), HasSubstr("closes_gaps: expected true or false"));
  EXPECT_THAT(fault("title = 1"), HasSubstr("title: expected a text"));
  EXPECT_THAT(fault("range_mm = 1"), HasSubstr("range_mm: expected a list"));
  EXPECT_THAT(fault("range_mm = ['a', 'b']"), HasSubstr("range_mm: expected a number"));
  EXPECT_THAT(fault("sides = ['left', 1]"),
              HasSubstr("sides: expected a list of texts, found a whole number"));
}

TEST(OptionsTest, AValueOutOfRangeIsNamedWithItsBounds) {
  EXPECT_THAT(fault("bandwidth_mm = 0"),
              StartsWith("example.toml:1: bandwidth_mm: is 0, expected a value in (0, 500]"));
  EXPECT_THAT(fault("bandwidth_mm = nan"), HasSubstr("expected a value in (0, 500]"));
  EXPECT_THAT(fault("count = 11"), HasSubstr("is 11, expected a value in [1, 10]"));
  EXPECT_THAT(fault("seed = -1"), HasSubstr("expected at least 0"));
  EXPECT_THAT(fault("side = 'up'"), HasSubstr("is \"up\", expected one of \"left\", \"right\""));
  EXPECT_THAT(fault("range_mm = [1]"), HasSubstr("holds 1 numbers, expected 2"));
  EXPECT_THAT(fault("range_mm = [1, 2, 3]"), HasSubstr("holds 3 numbers, expected 2"));
  EXPECT_THAT(fault("range_mm = [1, -1]"), HasSubstr("is -1"));
  EXPECT_THAT(fault("sides = ['up']"), HasSubstr("is \"up\""));
}

TEST(OptionsTest, AWholeNumberThatTheProgramCannotHoldIsOutOfRange) {
  struct AnyNumber {
    int number = 0;
    void visit(OptionVisitor& visitor) { visitor.integer("number", number, at_least(-1e15)); }
  };
  const auto fault_of_number = [](const std::string& toml) {
    AnyNumber options;
    return error_of([&] { OptionTable::parse(toml, "f").read(options); });
  };
  EXPECT_THAT(fault_of_number("number = 2147483648"),
              StartsWith("f:1: number: is 2147483648, which is out of range"));
  EXPECT_THAT(fault_of_number("number = -2147483649"), HasSubstr("is -2147483649, which is out of range"));
}

TEST(OptionsTest, AListOfTablesIsNoSingleTable) {
  const OptionTable root = OptionTable::parse("[a]\nx = 1\n", "f");
  EXPECT_THAT(error_of([&] { root.tables("a"); }),
              StartsWith("f:1: a: expected an array of tables, found a table"));
}

TEST(OptionsTest, BrokenTomlIsNamedWithItsLine) {
  EXPECT_THAT(fault("count = 1\nside = \n"), StartsWith("example.toml:2: no valid TOML"));
}

TEST(OptionsTest, NestedTablesAreReadOnceAndFinishedTogether) {
  const OptionTable root = OptionTable::parse("[a]\ncount = 2\n[[b]]\nx = 1\n[[b]]\ny = 'text'\n", "f");
  ExampleOptions options;
  root.table("a").read(options);
  EXPECT_EQ(options.count, 2);
  ASSERT_EQ(root.tables("b").size(), 2u);
  EXPECT_EQ(root.tables("b")[1].required_text("y"), "text");
  EXPECT_THAT(error_of([&] { root.finish(); }), StartsWith("f:4: b[1].x: unknown key"));
}

TEST(OptionsTest, AMissingTableIsEmpty) {
  const OptionTable root = OptionTable::parse("", "f");
  ExampleOptions options;
  root.table("a").read(options);
  EXPECT_EQ(options.count, 3);
  EXPECT_TRUE(root.tables("b").empty());
  EXPECT_THAT(error_of([&] { root.table("a").required_text("model"); }),
              StartsWith("f: a.model: is missing"));
  root.finish();
}

TEST(OptionsTest, WhatIsNoTableIsNotReadAsOne) {
  const OptionTable root = OptionTable::parse("x = 1\na = 2\n", "f");
  EXPECT_THAT(error_of([&] { root.table("a"); }),
              AllOf(StartsWith("f:2: a: expected a table"), HasSubstr("found a whole number")));
}

TEST(OptionsTest, ATableThatNobodyReadIsUnknown) {
  const OptionTable root = OptionTable::parse("[segmentatoin]\nx = 1", "f");
  root.table("segmentation");
  EXPECT_THAT(error_of([&] { root.finish(); }),
              HasSubstr("segmentatoin: unknown key (did you mean 'segmentation'?); known are segmentation"));
}

TEST(OptionsTest, WhatIsLeftToOthersIsNotUnknown) {
  const OptionTable root = OptionTable::parse("[estimator]\nmodel = 1", "f");
  root.leave("estimator");
  EXPECT_NO_THROW(root.finish());
}

TEST(OptionsTest, WhatWasResolvedReadsBackTheSameWithDefaultsIncluded) {
  const auto read_all = [](const OptionTable& root) {
    ExampleOptions options;
    root.table("a").read(options);
    for (const OptionTable& table : root.tables("b")) options.title += table.text_or("x", "default");
    root.finish();
    return options;
  };
  const OptionTable root = OptionTable::parse("[a]\ncount = 2\n[[b]]\nx = 'one'\n[[b]]\n", "f");
  const ExampleOptions options = read_all(root);
  const std::string resolved = root.resolved_toml();
  EXPECT_THAT(resolved, HasSubstr("bandwidth_mm = 13.5"));
  const OptionTable again = OptionTable::parse(resolved, "g");
  EXPECT_EQ(read_all(again).title, options.title);
  EXPECT_EQ(again.resolved_toml(), resolved);
}

TEST(OptionsTest, CheckingNamesTheOwnerFieldAndBound) {
  ExampleOptions options;
  options.count = 0;
  EXPECT_EQ(error_of([&] { check_options(options, "mean shift"); }),
            "mean shift: count is 0, expected a value in [1, 10]");
  options.count = 1;
  EXPECT_NO_THROW(check_options(options, "mean shift"));
}

TEST(OptionsTest, WhatIsWrittenReadsBackTheSame) {
  ExampleOptions options;
  options.bandwidth_mm = 0.1 + 0.2;
  options.title = "a \"quoted\" \\ line\n";
  options.seed = 1234567890123456789ull;
  options.sides = {"left", "right"};
  const ExampleOptions back = read(options_as_toml(options));
  EXPECT_EQ(back.bandwidth_mm, options.bandwidth_mm);
  EXPECT_EQ(back.title, options.title);
  EXPECT_EQ(back.seed, options.seed);
  EXPECT_EQ(back.sides, options.sides);
  EXPECT_EQ(back.closes_gaps, options.closes_gaps);
}

TEST(OptionsTest, PathsStartFromTheFilesFolder) {
  const testing::TemporaryFolder folder;
  write_text_file(folder / "pipeline.toml", "");
  EXPECT_EQ(OptionTable::load(folder / "pipeline.toml").resolved_path("models/x.h5"),
            folder.path() / "models/x.h5");
  EXPECT_EQ(OptionTable::load(folder / "pipeline.toml").resolved_path("/models/x.h5"), "/models/x.h5");
}

TEST(OptionsTest, ALineThatIsTheEndOfAnotherIsKept) {
  const OptionTable table = OptionTable::parse("other_kind = \"a\"\nkind = \"a\"\n", "p.toml");
  table.text_or("other_kind", "");
  table.text_or("kind", "");
  table.text_or("kind", "");
  EXPECT_EQ(table.resolved_toml(), "other_kind = 'a'\nkind = 'a'\n");
}

TEST(OptionsTest, TablesAndListsTooDeepInOneAnotherAreRefused) {
  const auto fault = [](const std::string& toml) {
    return testing::error_of([&] { OptionTable::parse(toml, "p.toml"); });
  };
  for (const std::string& open : {std::string("["), std::string("{a="), std::string("[[")}) {
    std::string toml = "b = 1\na = ";
    for (int i = 0; i < 10000; ++i) toml += open;
    EXPECT_THAT(fault(toml), ::testing::HasSubstr("p.toml:2: tables or lists"));
  }
  std::string dotted = "a";
  for (int i = 0; i < 10000; ++i) dotted += ".a";
  EXPECT_THAT(fault(dotted + " = 1\n"), ::testing::HasSubstr("p.toml:1: tables or lists"));
  EXPECT_THAT(fault("[" + dotted + "]\n"), ::testing::HasSubstr("p.toml:1: tables or lists"));
}

TEST(OptionsTest, BracketsInTextsAndCommentsDoNotCount) {
  std::string toml;
  for (int i = 0; i < 100; ++i) toml += fmt::format("a{} = \"[ \\\" [\" # in [0, 1)\nb{} = '[[\"'\n", i, i);
  toml += "c = \"\"\"\n[[[ \" \"\" [\"\"\"\nd = [0.1, 0.2, 0.3]\n";
  EXPECT_NO_THROW(OptionTable::parse(toml, "p.toml"));
}

}  // namespace
}  // namespace knuckle
