// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/open_source.h"

#include "knuckle/core/resources.h"
#include "knuckle/core/testing.h"
#include "knuckle/prepare/inputs.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using testing::error_of;
using ::testing::HasSubstr;

TEST(OpenSource, KnowsTheDataSetsAndTheGenerator) {
  EXPECT_THAT(source_kinds(), ElementsAre("folder", "icg", "icvl", "nyu", "msra15", "hands17", "h5",
                                          "fakenect", "rosbag", "mcap", "mkv", "oni", "synthetic"));
  EXPECT_TRUE(names_a_source("synthetic:m.toml"));
  EXPECT_TRUE(names_a_source("h5:C:/a.h5"));
  EXPECT_FALSE(names_a_source("synthetic"));
  EXPECT_FALSE(names_a_source("poses.txt"));
  EXPECT_FALSE(names_a_source("c:/poses.txt"));
}

TEST(OpenSource, NamesAnUnknownKindAndTheNearest) {
  EXPECT_THAT(
      error_of([] { open_source("synthetik:m.toml"); }),
      AllOf(HasSubstr("unknown kind of source 'synthetik' (did you mean 'synthetic'?)"),
            HasSubstr(
                "folder, icg, icvl, nyu, msra15, hands17, h5, fakenect, rosbag, mcap, mkv, oni, synthetic")));
}

TEST(OpenSource, TakesNoCameraAndNoUnknownStream) {
  EXPECT_THAT(error_of([] { open_source("v4l2:/dev/video0"); }),
              HasSubstr("is a camera, for `live` and `record`"));
  EXPECT_THAT(error_of([] { open_stream("synthetik:m.toml"); }),
              AllOf(HasSubstr("unknown kind of stream 'synthetik'"), HasSubstr("v4l2")));
}

TEST(OpenSource, TheGeneratorTakesSelectionsAndNoSettings) {
  const std::string demo = "synthetic:" + resource_path("manifests/demo.toml").string();
  EXPECT_EQ(open_source(demo + "?first=3&count=5&step=2")->size(), 5);
  EXPECT_EQ(open_source(demo + "?first=7&count=1")->read(0).depth_mm, open_source(demo)->read(7).depth_mm);
  EXPECT_THAT(error_of([&] { open_source(demo + "?view=2"); }), HasSubstr("view"));
  EXPECT_THAT(error_of([&] { open_source(demo + "?first=100000"); }), HasSubstr("source '" + demo));
}

TEST(OpenStream, PlaysASourceWithSettingsOfItsOwn) {
  const std::string demo = "synthetic:" + resource_path("manifests/demo.toml").string();
  const auto stream = open_stream(demo + "?first=3&count=3&rate=500&loop=1");
  for (const int index : {3, 4, 5, 3}) {
    const Frame frame = stream->next().value();
    EXPECT_EQ(frame.depth_mm, open_source(demo)->read(index).depth_mm);
  }
  EXPECT_THAT(error_of([&] { open_stream(demo + "?rate=fast"); }), HasSubstr("rate: expected a number"));
  EXPECT_THAT(error_of([&] { open_stream(demo + "?rate=-2"); }), HasSubstr("rate"));
  EXPECT_THAT(error_of([&] { open_stream(demo + "?speed=2"); }), HasSubstr("speed"));
  EXPECT_THAT(error_of([&] { open_source(demo + "?rate=2"); }), HasSubstr("rate"));
}

TEST(OpenSource, APathInAFileStartsAtTheFile) {
  const testing::TemporaryFolder folder;
  const auto source_of = [&](const std::string& text) {
    write_text_file(folder / "c.toml", "source = '" + text + "'\n");
    return source_in(OptionTable::load(folder / "c.toml"), "source");
  };
  EXPECT_EQ(source_of("h5:a/b.h5?first=3"), "h5:" + (folder / "a/b.h5?first=3").string());
  EXPECT_EQ(source_of("h5:/a/b.h5"), "h5:/a/b.h5");
  EXPECT_EQ(source_of("nonsense"), "nonsense");
}

TEST(Inputs, SayWhatAnOutcomeDependsOn) {
  const testing::TemporaryFolder folder;
  make_folder(folder / "set/depth");
  write_text_file(folder / "set/b.txt", "one");
  write_text_file(folder / "set/depth/a.txt", "two");
  const std::string one = content_hash(folder / "set/b.txt");
  const std::string two = content_hash(folder / "set/depth/a.txt");
  EXPECT_NE(one, two);
  EXPECT_EQ(Inputs().add("patch", "32 px").add_content("set", folder / "set").text(),
            "patch: 32 px\nset/b.txt: " + one + "\nset/depth/a.txt: " + two + "\n");
  EXPECT_EQ(
      Inputs().add_source("source", "folder:" + (folder / "set").string() + "?first=3").text(),
      "source: folder?first=3\nsource content/b.txt: " + one + "\nsource content/depth/a.txt: " + two + "\n");
  EXPECT_EQ(Inputs().add_content_if_there("x", folder / "none").text(), "x: none\n");
  EXPECT_EQ(Inputs().add_content_if_there("x", folder / "set/b.txt").text(), "x: " + one + "\n");
  write_text_file(folder / "p.toml",
                  "[segmentation]\nmodel = 'set/b.txt'\n[estimator]\nmodel = 'set/depth/a.txt'\n");
  EXPECT_EQ(Inputs().add_models(folder / "p.toml").text(),
            "segmentation model: " + one + "\nestimator model: " + two + "\n");
  write_text_file(folder / "p.toml", "[estimator]\nmodels = ['set/depth/a.txt', 'set/b.txt']\n");
  EXPECT_EQ(Inputs().add_models(folder / "p.toml").text(),
            "estimator model: " + two + "\nestimator model: " + one + "\n");
}

}  // namespace
}  // namespace knuckle
