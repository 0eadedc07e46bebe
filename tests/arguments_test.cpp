// SPDX-License-Identifier: Apache-2.0
// Arguments that are well formed, but do not go together with each other or with the files that they name.
#include "program.h"

#include <array>
#include <cstdio>

#include <fmt/format.h>

#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

class ArgumentsTest : public ::testing::Test {
 protected:
  ArgumentsTest() {
    write_set("plain", "");
    write_set("labelled", "convention = 'icg20'\n");
    write_text_file(path("labelled/joints.txt"), pose_ + "\n");
    write_text_file(path("one.txt"), "# convention: icg20\n" + pose_ + "\n");
    write_text_file(path("two.txt"), "# convention: icg20\n" + pose_ + "\n" + pose_ + "\n");
  }
  std::string path(const std::string& name) const { return folder_ / name; }
  /// A folder set of one frame.
  void write_set(const std::string& name, const std::string& description) const {
    make_folder(path(name + "/depth"));
    write_text_file(path(name + "/dataset.toml"),
                    description +
                        "[camera]\nmodel = 'projective'\nwidth = 64\nheight = 48\nfx = 60\nfy = 60\ncx = 32\n"
                        "cy = 24\n");
    write_png(path(name + "/depth/000000.png"), Image<std::uint16_t>(64, 48, 300));
  }
  ProgramRun evaluate(const std::string& truth, const std::vector<std::string>& others) const {
    std::vector<std::string> arguments{"evaluate", "--truth", truth};
    arguments.insert(arguments.end(), others.begin(), others.end());
    return run_program(arguments);
  }
  ProgramRun labels(const std::string& verb, const std::string& set,
                    const std::vector<std::string>& others) const {
    std::vector<std::string> arguments{"labels", verb, "--source", set, "--labels", path("labels")};
    arguments.insert(arguments.end(), others.begin(), others.end());
    return run_program(arguments);
  }

  static std::string joints() {
    std::string line;
    for (int i = 0; i < 20; ++i) line += fmt::format("{}{} {} 300", i == 0 ? "" : " ", 20 + i, 24);
    return line;
  }

  const std::string pose_ = joints();
  TemporaryFolder folder_;
  std::string plain_ = "folder:" + path("plain");
  std::string labelled_ = "folder:" + path("labelled");
};

TEST_F(ArgumentsTest, ATruthOfAFileNeedsACameraAndKnowsOneHandAlone) {
  EXPECT_THAT(evaluate(path("one.txt"), {"--predictions", "a=" + path("one.txt")}),
              FailedWith("one.txt: truth from a file needs its camera"));
  EXPECT_THAT(evaluate(path("one.txt"), {"--camera", "60,60,32,24", "--records", "a=" + path("a.jsonl")}),
              FailedWith("--records: hands are scored against a source"));
}

TEST_F(ArgumentsTest, AStripShowsEstimates) {
  EXPECT_THAT(evaluate(labelled_, {"--boxes", "a=" + path("a.txt"), "--strip", path("strip.png")}),
              FailedWith("--strip shows estimates: give --predictions NAME=PATH or --records NAME=PATH"));
}

TEST_F(ArgumentsTest, WithoutTruthThereArePicturesAlone) {
  const std::vector<std::string> poses{"--predictions", "a=" + path("one.txt")};
  const auto with = [&](std::vector<std::string> others) {
    others.insert(others.end(), poses.begin(), poses.end());
    return evaluate(plain_, others);
  };
  const char* const fault = "the source has no truth to score against";
  EXPECT_THAT(with({}), FailedWith(fault));
  EXPECT_THAT(with({"--out", path("report"), "--json", path("scores.json")}), FailedWith(fault));
  EXPECT_THAT(with({"--out", path("report"), "--boxes", "a=" + path("a.txt")}), FailedWith(fault));
  EXPECT_THAT(with({"--json", path("scores.json"), "--records", "a=" + path("a.jsonl")}), FailedWith(fault));
  EXPECT_THAT(with({"--out", path("report"), "--records", "a=" + path("none.jsonl")}),
              FailedWith("none.jsonl: cannot read"));
  EXPECT_THAT(with({"--strip", path("strip.png"), "--format", "xyz"}),
              FailedWith("--format: without truth poses are looked at in the image"));
  EXPECT_THAT(evaluate(plain_, {"--strip", path("strip.png"), "--predictions", "a=" + path("two.txt")}),
              FailedWith("two.txt: holds 2 poses, the source " + plain_ + " has 1 frames"));
  EXPECT_FALSE(std::filesystem::exists(path("strip.png")));
  EXPECT_FALSE(std::filesystem::exists(path("report")));
}

TEST_F(ArgumentsTest, LabelsAreImportedFromWhatHasThem) {
  EXPECT_THAT(labels("import", plain_, {}), FailedWith("has no labels of its own; give --poses"));
  EXPECT_THAT(labels("import", plain_, {"--poses", path("two.txt")}),
              FailedWith("two.txt: 2 poses, the source has 1 frames"));
  EXPECT_FALSE(std::filesystem::exists(path("labels")));
}

TEST_F(ArgumentsTest, HandsThatAreLessSureAreNoLabelsThatWereAskedFor) {
  for (const std::string author : {"ann", "bea"}) {
    ASSERT_THAT(labels("import", labelled_, {"--author", author, "--state", "estimated"}), Succeeded());
  }
  EXPECT_THAT(labels("export", labelled_, {"--author", "ann", "--state", "verified", "--out", path("set")}),
              FailedWith("labels: no hand is verified; --state says how sure hands have to be"));
  EXPECT_FALSE(std::filesystem::exists(path("set")));
  const auto compare = [&](const std::string& state) {
    return run_program(
        {"labels", "compare", "--labels", path("labels"), "--authors", "ann", "bea", "--state", state});
  };
  EXPECT_THAT(compare("verified"), FailedWith("labels: no hand is verified in the labels of both"));
  EXPECT_THAT(compare("estimated"), Succeeded());
}

TEST_F(ArgumentsTest, AForestIsShrunkInSomeWayThatItHas) {
  const auto shrink = [&](const std::string& model, const std::vector<std::string>& others) {
    std::vector<std::string> arguments{"shrink", "--model", model, "--out", path("small.model")};
    arguments.insert(arguments.end(), others.begin(), others.end());
    return run_program(arguments);
  };
  EXPECT_THAT(shrink("models/segmentation_forest.model", {}),
              FailedWith("give --leaves, --leaf-step, or both"));
  EXPECT_THAT(shrink("models/segmentation_forest.model", {"--leaf-step", "0.2", "--leaves", "100"}),
              FailedWith("segmentation_forest.model: a segmentation forest's leaves are single bytes"));
  EXPECT_FALSE(std::filesystem::exists(path("small.model")));
}

TEST_F(ArgumentsTest, FramesAreRenderedThatThereAre) {
  const auto render = [&](const std::vector<std::string>& others) {
    std::vector<std::string> arguments{"render", "--manifest", "manifests/demo.toml", "--out", path("a.h5")};
    arguments.insert(arguments.end(), others.begin(), others.end());
    return run_program(arguments);
  };
  EXPECT_THAT(render({"--first", "40"}), FailedWith("demo.toml: frames 40 to 40 were asked for, it has 40"));
  EXPECT_THAT(render({"--first", "30", "--count", "11"}), FailedWith("frames 30 to 41 were asked for"));
  EXPECT_FALSE(std::filesystem::exists(path("a.h5")));
}

TEST_F(ArgumentsTest, ADetectorHasNoHandsThatAreCutOut) {
  const auto train = [&](const std::vector<std::string>& others) {
    std::vector<std::string> arguments{"train", "network",   "--config", "pipelines/train_detector.toml",
                                       "--out", path("a.pt")};
    arguments.insert(arguments.end(), others.begin(), others.end());
    return run_program(arguments);
  };
  EXPECT_THAT(train({"--check"}), FailedWith("--check shows hands that are cut out"));
  EXPECT_THAT(train({"--cache", path("cache")}), FailedWith("--cache keeps hands that were cut out"));
}

TEST_F(ArgumentsTest, AProgramWithoutTheOneThatTrainsSaysWhichIsMissing) {
  std::filesystem::copy_file(KNUCKLE_PROGRAM, path("knuckle"));  // nothing lies beside it
  const std::string command =
      path("knuckle") + " train network --config pipelines/train_dense.toml --out " + path("a.pt") + " 2>&1";
  std::FILE* const output = ::popen(command.c_str(), "r");
  ASSERT_NE(output, nullptr);
  std::array<char, 4096> text{};
  const std::size_t length = std::fread(text.data(), 1, text.size() - 1, output);
  EXPECT_NE(::pclose(output), 0);
  EXPECT_THAT(std::string(text.data(), length), HasSubstr("knuckle-train-network: is missing: it does this"));
}

}  // namespace
}  // namespace knuckle::testing
