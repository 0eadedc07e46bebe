// SPDX-License-Identifier: Apache-2.0
// `evaluate` as a user types it.
#include "verbs.h"

#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(VerbsTest, EstimatesAreEvaluatedAgainstTheirSource) {
  ASSERT_THAT(run_program({"estimate", "--source", kSixFrames, "--pipeline", "pipelines/default.toml",
                           "--init", "truth", "--out", path("poses.txt"), "--json", path("summary.json")}),
              Succeeded());
  const auto lines = read_lines(path("poses.txt"));
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0], "# convention: knuckle22");
  const auto summary = nlohmann::json::parse(read_text_file(path("summary.json")));
  EXPECT_EQ(summary["frames"], 6);
  EXPECT_EQ(summary["found"], 6);

  ASSERT_THAT(run_program({"evaluate", "--truth", kSixFrames, "--predictions", "forest=" + path("poses.txt"),
                           "--json", path("scores.json"), "--out", path("report")}),
              Succeeded());
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_EQ(scores["methods"][0]["frames"], 6);
  EXPECT_GT(scores["methods"][0]["mean_3d_mm"], 0.0);
  EXPECT_LT(scores["methods"][0]["mean_3d_mm"], 60.0);
  EXPECT_THAT(read_text_file(path("report/report.html")), HasSubstr("<svg"));
  for (const std::string options : {"report/options.toml", "scores.json.options.toml"}) {
    EXPECT_THAT(read_text_file(path(options)), HasSubstr(fmt::format("truth = '{}'", kSixFrames)));
    EXPECT_THAT(read_text_file(path(options)), HasSubstr("even_frames = 8"));
  }
}

TEST_F(VerbsTest, ASourceWithoutTruthGivesAReportOfPictures) {
  ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--format", "folder", "--out",
                           path("set"), "--count", "2"}),
              Succeeded());
  std::filesystem::remove(path("set/joints.txt"));
  const std::string source = "folder:" + path("set");
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("poses.txt")}), Succeeded());
  const std::string predictions = "x=" + path("poses.txt");
  EXPECT_THAT(run_program({"evaluate", "--truth", source, "--predictions", predictions}),
              FailedWith("no truth"));
  ASSERT_THAT(
      run_program({"evaluate", "--truth", source, "--predictions", predictions, "--out", path("report")}),
      Succeeded());
  EXPECT_THAT(read_text_file(path("report/report.html")), HasSubstr("data:image/png;base64,"));
  EXPECT_THAT(run_program({"evaluate", "--truth", source + "?count=1", "--predictions", predictions, "--out",
                           path("other")}),
              FailedWith("poses.txt"));
}

TEST_F(VerbsTest, PosesInSpaceAreScoredAndMixedUpOnesAreNoticed) {
  const std::string source = "synthetic:manifests/demo.toml?count=3";
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("poses.txt"), "--records",
                           path("poses.jsonl")}),
              Succeeded());
  std::string in_metres;  // as a program with OpenGL's axes writes them
  std::istringstream records(read_text_file(path("poses.jsonl")));
  for (std::string line; std::getline(records, line);) {
    const auto hands = nlohmann::ordered_json::parse(line)["hands"];
    ASSERT_FALSE(hands.empty());
    for (const auto& point : hands[0]["landmarks_mm"]) {
      in_metres += fmt::format("{} {} {} ", point[0].get<double>() / 1000, -point[1].get<double>() / 1000,
                               -point[2].get<double>() / 1000);
    }
    in_metres += "\n";
  }
  write_text_file(path("space.txt"), in_metres);
  std::vector<std::string> arguments = {"evaluate",
                                        "--truth",
                                        source,
                                        "--predictions",
                                        "space=" + path("space.txt"),
                                        "pixels=" + path("poses.txt"),
                                        "--convention",
                                        "knuckle22",
                                        "--json",
                                        path("scores.json")};
  const ProgramRun mixed_up = run_program(arguments);
  EXPECT_THAT(mixed_up, Succeeded());
  EXPECT_THAT(mixed_up.error, HasSubstr("space.txt: read so, half of its joints are more than"));
  EXPECT_THAT(mixed_up.error, HasSubstr("with --format xyz --axes x,-y,-z --unit m more than"));
  EXPECT_THAT(mixed_up.error, Not(HasSubstr("poses.txt")));
  const ProgramRun behind =
      run_program({"evaluate", "--truth", source, "--predictions", "space=" + path("space.txt"),
                   "--convention", "knuckle22", "--format", "xyz"});
  EXPECT_THAT(behind, Succeeded());
  EXPECT_THAT(behind.error, HasSubstr("half of its joints are behind the camera; with --format xyz --axes"));
  write_text_file(path("space.txt"), "# format: xyz\n# axes: x,-y,-z\n# unit: m\n" + in_metres);
  const ProgramRun right = run_program(arguments);
  EXPECT_THAT(right, Succeeded());
  EXPECT_EQ(right.error, "");
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_NEAR(scores["methods"][0]["mean_3d_mm"], scores["methods"][1]["mean_3d_mm"], 0.01);
  EXPECT_NEAR(scores["differences"][0]["mean_mm"], 0.0, 0.01);
  arguments.insert(arguments.end(), {"--axes", "x,-y,-z"});
  EXPECT_THAT(run_program(arguments), FailedWith("--axes: tells of x y z"));
}

TEST_F(VerbsTest, AMethodThatFoundNothingHasAReport) {
  std::string nothing = "# convention: hands21\n";
  for (int i = 0; i < 3; ++i) {
    for (int number = 0; number < 63; ++number) nothing += "nan ";
    nothing += "\n";
  }
  write_text_file(path("nothing.txt"), nothing);
  const ProgramRun run =
      run_program({"evaluate", "--truth", "synthetic:manifests/demo.toml?count=3", "--predictions",
                   "nothing=" + path("nothing.txt"), "--out", path("report")});
  EXPECT_THAT(run, Succeeded());
  EXPECT_EQ(run.error, "");
  EXPECT_THAT(read_text_file(path("report/report.html")), HasSubstr("nothing"));
}

TEST_F(VerbsTest, FittedSurfacesAreShownWithAndWithoutTruth) {
  const std::string labelled = "synthetic:manifests/test_creative.toml?count=3";
  ASSERT_THAT(run_program({"estimate", "--source", labelled, "--pipeline", "pipelines/track.toml", "--out",
                           path("p.txt"), "--records", path("p.jsonl")}),
              Succeeded());
  ASSERT_THAT(run_program({"render", "--manifest", "manifests/test_creative.toml", "--format", "folder",
                           "--out", path("set"), "--count", "3"}),
              Succeeded());
  std::filesystem::remove(path("set/joints.txt"));
  for (const std::string& source : {labelled, "folder:" + path("set")}) {
    ASSERT_THAT(run_program({"evaluate", "--truth", source, "--records", "m=" + path("p.jsonl"), "--out",
                             path("report"), "--strip", path("strip.png")}),
                Succeeded());
    const std::string page = read_text_file(path("report/report.html"));
    EXPECT_THAT(page, HasSubstr("<img alt=\"m: surface\""));
    EXPECT_THAT(page, HasSubstr("<img alt=\"m: difference\""));
    EXPECT_THAT(page, HasSubstr("aria-label=\"index_pip\""));
    EXPECT_TRUE(std::filesystem::exists(path("report/figures/angle_index_pip.svg")));
    EXPECT_TRUE(std::filesystem::exists(path("strip.png")));
    std::filesystem::remove_all(path("report"));
    std::filesystem::remove(path("strip.png"));
  }
}

}  // namespace
}  // namespace knuckle::testing
