// SPDX-License-Identifier: Apache-2.0
// Landmarks of others: `landmarks`, and `--landmarks` of `estimate` and `evaluate`.
#include "verbs.h"

#include <filesystem>

#include <nlohmann/json.hpp>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

/// "mean mm" of a method in what `evaluate --json` wrote.
double mean_error_mm(const std::string& file) {
  return nlohmann::json::parse(read_text_file(file))["methods"][0]["mean_3d_mm"];
}

TEST_F(VerbsTest, LandmarksThatAreLabelledElsewhereAreLearnedAndApplied) {
  const std::string source = "synthetic:manifests/demo.toml?count=24";
  const std::string fitted = source + "&step=2";
  const std::string held_out = source + "&first=1&step=2";
  ASSERT_THAT(run_program({"landmarks", "--source", fitted, "--out", path("marks.toml")}), Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", held_out, "--init", "truth", "--out", path("plain.txt")}),
              Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", held_out, "--init", "truth", "--landmarks",
                           path("marks.toml"), "--out", path("moved.txt"), "--records", path("moved.jsonl")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", held_out, "--predictions", "m=" + path("plain.txt"),
                           "--landmarks", path("marks.toml"), "--json", path("moved_later.json")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", held_out, "--predictions", "m=" + path("moved.txt"),
                           "--json", path("moved.json")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", held_out, "--predictions", "m=" + path("plain.txt"),
                           "--json", path("plain.json")}),
              Succeeded());
  EXPECT_NEAR(mean_error_mm(path("moved.json")), mean_error_mm(path("moved_later.json")), 0.002);
  EXPECT_GT(std::abs(mean_error_mm(path("moved.json")) - mean_error_mm(path("plain.json"))), 0.002)
      << "moved";
}

TEST_F(VerbsTest, SyntheticFramesAreScoredInTheLandmarksOfADataSet) {
  const std::string source = "synthetic:manifests/demo.toml?count=4";
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("poses.txt")}), Succeeded());
  for (const auto& [file, count] : {std::pair{"landmarks/nyu14.toml", 14},
                                    {"landmarks/icvl16.toml", 16},
                                    {"mediapipe21", 21},
                                    {"icg20", 20}}) {
    ASSERT_THAT(run_program({"evaluate", "--truth", source, "--predictions", "m=" + path("poses.txt"),
                             "--landmarks", file, "--json", path("scores.json")}),
                Succeeded());
    const auto method = nlohmann::json::parse(read_text_file(path("scores.json")))["methods"][0];
    EXPECT_EQ(method["joints"].size(), count);
    for (const auto& error : method["per_joint_3d_mm"]) EXPECT_LT(error, 60.0);
  }
}

TEST_F(VerbsTest, MethodsWithADataSetsOwnLandmarksAreScoredBesideThoseThatAreMovedThere) {
  const std::string source = "synthetic:manifests/demo.toml?count=4";
  const auto estimate = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"estimate", "--source", source, "--out", path(name)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    ASSERT_THAT(run_program(arguments), Succeeded());
  };
  estimate("all22.txt", {});
  estimate("own14.txt", {"--landmarks", "nyu14"});
  ASSERT_THAT(run_program({"evaluate", "--truth", source, "--predictions", "moved=" + path("all22.txt"),
                           "--predictions", "own=" + path("own14.txt"), "--landmarks", "nyu14", "--json",
                           path("scores.json")}),
              Succeeded());
  const auto methods = nlohmann::json::parse(read_text_file(path("scores.json")))["methods"];
  ASSERT_EQ(methods.size(), 2u);
  for (const auto& method : methods) EXPECT_EQ(method["joints"].size(), 14u);
  EXPECT_NEAR(methods[0]["mean_3d_mm"], methods[1]["mean_3d_mm"], 0.002);
}

TEST_F(VerbsTest, ADataSetMayHaveLandmarksOfItsOwn) {
  write_text_file(path("lab3.toml"),
                  "format = \"knuckle-landmarks\"\nversion = 1\nconvention = \"lab3\"\n"
                  "landmarks = [\"thumb_tip\", \"middle_of_index\", \"wrist\"]\n"
                  "[middle_of_index]\nbone = \"index_mcp\"\ntowards = \"index_tip\"\nshare = 0.5\n");
  ASSERT_THAT(run_program({"estimate", "--source", kSixFrames, "--landmarks", path("lab3.toml"), "--out",
                           path("lab3.txt"), "--records", path("lab3.jsonl")}),
              Succeeded());
  EXPECT_THAT(read_text_file(path("lab3.txt")), StartsWith("# convention: lab3\n"));
  EXPECT_THAT(read_text_file(path("lab3.jsonl")), HasSubstr("\"middle_of_index\":["));
  // Its own poses are its truth: the folder set says the convention by the file beside it.
  std::filesystem::create_directories(path("set") + "/depth");
  const std::string joints = read_text_file(path("lab3.txt"));
  write_text_file(path("set/joints.txt"), joints.substr(joints.find('\n') + 1));
  std::filesystem::copy(path("lab3.toml"), path("set/lab3.toml"));
  write_text_file(path("set/dataset.toml"),
                  "convention = \"lab3.toml\"\n[camera]\nwidth = 320\nheight = 240\nfx = 224.5\nfy = 230.5\n"
                  "cx = 160.0\ncy = 120.0\n");
  for (int i = 0; i < 6; ++i)
    write_png(path("set/depth/" + std::to_string(i) + ".png"), Image<std::uint16_t>(320, 240, 900));
  ASSERT_THAT(run_program({"evaluate", "--truth", "folder:" + path("set"), "--predictions",
                           "own=" + path("lab3.txt"), "--json", path("own.json")}),
              Succeeded());
  EXPECT_LT(mean_error_mm(path("own.json")), 0.01);
  write_text_file(path("set/dataset.toml"),
                  "convention = \"../lab3.toml\"\n[camera]\nwidth = 320\nheight = 240\n"
                  "fx = 224.5\nfy = 230.5\ncx = 160.0\ncy = 120.0\n");
  EXPECT_THAT(run_program({"inspect", "--source", "folder:" + path("set")}),
              FailedWith("expected the name of a file in the same folder"));
}

TEST_F(VerbsTest, LandmarksSayWhatIsWrong) {
  EXPECT_THAT(run_program({"landmarks", "--source", kSixFrames, "--out", path("marks.toml")}),
              FailedWith("too few to fit"));
  EXPECT_FALSE(std::filesystem::exists(path("marks.toml")));
  EXPECT_THAT(run_program({"landmarks", "--source", kSixFrames, "--out", path("none/marks.toml")}),
              FailedWith("none/marks.toml"));
  EXPECT_THAT(run_program({"estimate", "--source", kSixFrames, "--landmarks", path("no.toml"), "--out",
                           path("p.txt")}),
              FailedWith("no.toml"));
  write_text_file(path("marks.toml"),
                  "format = \"knuckle-landmarks\"\nversion = 1\nconvention = \"icg20\"\n");
  EXPECT_THAT(run_program({"estimate", "--source", kSixFrames, "--landmarks", path("marks.toml"), "--out",
                           path("p.txt")}),
              FailedWith("lacks the table [palm]"));
  EXPECT_FALSE(std::filesystem::exists(path("p.txt")));
}

}  // namespace
}  // namespace knuckle::testing
