// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/source_spec.h"

#include <array>

#include "knuckle/core/testing.h"
#include "knuckle/data/readers/open_dataset.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

constexpr std::array<std::string_view, 2> kColours{"red", "green"};

struct ExampleOptions {
  int view = 1;
  double scale = 1.0;
  std::string name;
  bool mirrored = false;
  std::uint64_t seed = 1;
  std::string colour = "red";
  std::vector<std::string> colours;
  std::vector<double> weights;

  void visit(OptionVisitor& visitor) {
    visitor.integer("view", view, closed(1, 3));
    visitor.real("scale", scale, above(0));
    visitor.text("name", name);
    visitor.flag("mirrored", mirrored);
    visitor.seed("seed", seed);
    visitor.choice("colour", colour, kColours);
    visitor.texts("colours", colours, kColours);
    visitor.reals("weights", weights, closed(0, 1), 1, 2);
  }
};

ExampleOptions example(const std::string& text) {
  return options_from<ExampleOptions>(parse_source_spec(text));
}

TEST(SourceSpec, TakesKindPathSelectionAndSettingsApart) {
  const SourceSpec spec = parse_source_spec("nyu:/sets/nyu/test?view=2&first=10&count=20&step=3");
  EXPECT_EQ(spec.kind, "nyu");
  EXPECT_EQ(spec.path, "/sets/nyu/test");
  EXPECT_EQ(spec.selection, (FrameSelection{10, 20, 3}));
  ASSERT_EQ(spec.settings.size(), 1u);
  EXPECT_EQ(spec.settings[0].first, "view");
  EXPECT_EQ(spec.settings[0].second, "2");
}

TEST(SourceSpec, KeepsColonsAndQuestionMarksOfThePath) {
  const SourceSpec spec = parse_source_spec("folder:/a:b/what?/c?count=2");
  EXPECT_EQ(spec.path, "/a:b/what?/c");
  EXPECT_EQ(spec.selection.count, 2);
  EXPECT_TRUE(parse_source_spec("folder:x").selection.takes_all());
}

TEST(SourceSpec, RefusesWhatIsNoSource) {
  EXPECT_THAT(error_of([] { parse_source_spec("/just/a/path"); }), HasSubstr("KIND:PATH"));
  EXPECT_THAT(error_of([] { parse_source_spec(":/a/path"); }), HasSubstr("names no kind"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:"); }), HasSubstr("names no path"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?view"); }), HasSubstr("'view' is not key=value"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?=2"); }), HasSubstr("'=2' is not key=value"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?view=1&view=2"); }), HasSubstr("'view' appears twice"));
}

TEST(SourceSpec, RefusesSelectionsThatAreNoNumbersOrOutOfRange) {
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?first=abc"); }),
              AllOf(HasSubstr("first"), HasSubstr("'abc'")));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?first=1.5"); }), HasSubstr("1.5"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?first=-1"); }), HasSubstr("first = -1"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?count=0"); }), HasSubstr("count = 0"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?step=0"); }), HasSubstr("step = 0"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?count=99999999999"); }), HasSubstr("count"));
  EXPECT_THAT(error_of([] { parse_source_spec("nyu:x?count="); }), HasSubstr("count"));
}

TEST(SourceSpec, SetsTheReadersOptions) {
  const ExampleOptions options = example("x:y?view=3&scale=0.5&name=me&first=2");
  EXPECT_EQ(options.view, 3);
  EXPECT_EQ(options.scale, 0.5);
  EXPECT_EQ(options.name, "me");
  EXPECT_EQ(example("x:y").view, 1);
  const ExampleOptions others =
      example("x:y?mirrored=true&seed=7&colour=green&colours=green,red&weights=0.5");
  EXPECT_TRUE(others.mirrored);
  EXPECT_EQ(others.seed, 7u);
  EXPECT_EQ(others.colour, "green");
  EXPECT_THAT(others.colours, ::testing::ElementsAre("green", "red"));
  EXPECT_THAT(others.weights, ::testing::ElementsAre(0.5));
}

struct FlagOptions {
  bool is_on = false;

  void visit(OptionVisitor& visitor) { visitor.flag("is_on", is_on); }
};

TEST(SourceSpec, AFlagIsTrueOrFalse) {
  const auto flag = [](const std::string& text) {
    return options_from<FlagOptions>(parse_source_spec("x:y?is_on=" + text)).is_on;
  };
  EXPECT_TRUE(flag("true"));
  EXPECT_FALSE(flag("false"));
  for (const std::string text : {"", "1", "True"})
    EXPECT_THAT(error_of([&] { flag(text); }), HasSubstr("is_on: '" + text + "' is neither true nor false"));
}

TEST(SourceSpec, UnknownKeysAndBadValuesAreErrors) {
  EXPECT_THAT(error_of([] { example("x:y?veiw=3"); }),
              AllOf(HasSubstr("unknown key 'veiw'"), HasSubstr("first, count, step, view, scale, name")));
  EXPECT_THAT(error_of([] { example("x:y?view=4"); }), HasSubstr("view = 4 is not in [1, 3]"));
  EXPECT_THAT(error_of([] { example("x:y?view=two"); }), HasSubstr("'two'"));
  EXPECT_THAT(error_of([] { example("x:y?scale=0"); }), HasSubstr("scale = 0"));
  EXPECT_THAT(error_of([] { example("x:y?scale=nan"); }), HasSubstr("scale"));
  EXPECT_THAT(error_of([] { example("x:y?mirrored=yes"); }),
              HasSubstr("source 'x:y?mirrored=yes': mirrored: 'yes' is neither true nor false"));
  EXPECT_THAT(error_of([] { example("x:y?seed=-1"); }), HasSubstr("seed = -1 is not in"));
  EXPECT_THAT(error_of([] { example("x:y?colour=blue"); }),
              HasSubstr("colour: 'blue' is unknown; known are red, green"));
  EXPECT_THAT(error_of([] { example("x:y?colours=red,blue"); }), HasSubstr("colours: 'blue' is unknown"));
  EXPECT_THAT(error_of([] { example("x:y?weights=1,0.5,1"); }),
              HasSubstr("weights: has 3 numbers, expected 1 to 2"));
  EXPECT_THAT(error_of([] { example("x:y?weights=1,2"); }), HasSubstr("weights = 2 is not in [0, 1]"));
  EXPECT_THAT(error_of([] { require_no_settings(parse_source_spec("x:y?a=1")); }),
              HasSubstr("unknown key 'a'"));
}

TEST(OpenDataset, ListsTheKindsWhereOneIsUnknown) {
  EXPECT_THAT(error_of([] { open_dataset("nyuu:/x"); }),
              AllOf(HasSubstr("unknown kind 'nyuu'"),
                    HasSubstr("folder, icg, icvl, nyu, msra15, hands17, h5, fakenect, rosbag, mcap, mkv")));
}

TEST(OpenDataset, EveryKindNamesAMissingPath) {
  for (const DatasetKind& kind : dataset_kinds()) {
    EXPECT_THAT(error_of([&] { open_dataset(std::string(kind.name) + ":/no/such/place"); }),
                HasSubstr("/no/such/place"))
        << kind.name;
  }
}

TEST(OpenDataset, EveryKindRefusesUnknownKeys) {
  for (const DatasetKind& kind : dataset_kinds()) {
    EXPECT_THAT(error_of([&] { open_dataset(std::string(kind.name) + ":/no/such/place?colour=red"); }),
                HasSubstr("unknown key 'colour'"))
        << kind.name;
  }
}

TEST(OpenDataset, EveryKindRefusesAnEmptySource) {
  const testing::TemporaryFolder folder;
  for (const DatasetKind& kind : dataset_kinds()) {
    EXPECT_THAT(error_of([&] { open_dataset(std::string(kind.name) + ":" + folder.path().string()); }),
                HasSubstr(folder.path().string()))
        << kind.name;
  }
}

}  // namespace
}  // namespace knuckle
