// SPDX-License-Identifier: Apache-2.0
// `estimate` as a user types it: hands that are missing, followed, left ones.
#include "verbs.h"

#include <filesystem>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::StartsWith;

TEST_F(VerbsTest, AFrameWithoutAHandIsALineOfNanAndAMissingPrediction) {
  make_folder(path("set/depth"));
  write_text_file(
      path("set/dataset.toml"),
      "convention = 'icg20'\n[camera]\nmodel = 'projective'\nwidth = 32\nheight = 24\nfx = 30\nfy = 30\n"
      "cx = 16\ncy = 12\n");
  write_png(path("set/depth/0.png"), Image<std::uint16_t>(32, 24));
  std::string truth;
  for (int i = 0; i < 20; ++i) truth += "10 10 400 ";
  write_text_file(path("set/joints.txt"), truth + "\n");
  ASSERT_THAT(run_program({"estimate", "--source", "folder:" + path("set"), "--out", path("poses.txt")}),
              Succeeded());
  EXPECT_THAT(read_lines(path("poses.txt"))[1], StartsWith("nan nan nan"));
  ASSERT_THAT(run_program({"evaluate", "--truth", "folder:" + path("set"), "--predictions",
                           "x=" + path("poses.txt"), "--json", path("scores.json")}),
              Succeeded());
  EXPECT_EQ(nlohmann::json::parse(read_text_file(path("scores.json")))["methods"][0]["missing"], 1);
}

TEST_F(VerbsTest, AHandThatIsFollowedKeepsItsIdAndTremblesLess) {
  const std::string source = "synthetic:manifests/test_creative.toml?count=40";
  ASSERT_THAT(run_program({"estimate", "--source", source, "--out", path("single.txt")}), Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", source, "--pipeline", "pipelines/track.toml", "--out",
                           path("followed.txt"), "--records", path("followed.jsonl")}),
              Succeeded());
  ASSERT_THAT(run_program({"evaluate", "--truth", source, "--predictions", "single=" + path("single.txt"),
                           "followed=" + path("followed.txt"), "--json", path("both.json")}),
              Succeeded());
  const auto methods = nlohmann::json::parse(read_text_file(path("both.json")))["methods"];
  EXPECT_LT(methods[1]["motion"]["acceleration_mm"],
            0.8 * methods[0]["motion"]["acceleration_mm"].get<double>());
  EXPECT_LT(methods[1]["motion"]["bone_deviation"], 0.02);
  EXPECT_LT(methods[1]["mean_3d_mm"], 1.3 * methods[0]["mean_3d_mm"].get<double>());
  std::istringstream lines(read_text_file(path("followed.jsonl")));
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const auto hand = nlohmann::json::parse(line)["hands"].at(0);
    EXPECT_EQ(hand["id"], 1);
    EXPECT_EQ(hand["skeleton"], "adult");
    EXPECT_EQ(hand["angles_rad"].size(), 22u);
  }
  EXPECT_EQ(count, 40);
  EXPECT_THAT(run_program({"estimate", "--source", source, "--pipeline", "pipelines/track.toml", "--init",
                           "truth", "--out", path("p.txt")}),
              FailedWith("--init truth"));
}

TEST_F(VerbsTest, ALeftHandIsEstimatedAsItsMirrorImage) {
  // A frame and its mirror image, the one with side = right, the other with side = left.
  const std::string pipeline = read_text_file("pipelines/pose_forest.toml");
  const std::string model = std::filesystem::absolute("models/pose_forest.model");
  const auto with = [&](std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string right = with(pipeline, "../models/pose_forest.model", model);
  write_text_file(path("right.toml"), right);
  write_text_file(path("left.toml"), with(right, "side = \"right\"", "side = \"left\""));
  make_folder(path("a/depth"));
  make_folder(path("b/depth"));
  ASSERT_THAT(run_program({"render", "--manifest", "manifests/demo.toml", "--format", "folder", "--out",
                           path("frames"), "--count", "1"}),
              Succeeded());
  const auto depth_file = entries_of(path("frames/depth")).front();
  const auto depth = read_png16(path("frames/depth/" + depth_file));
  const std::string toml =
      "depth_unit_mm = 0.1\n[camera]\nmodel = 'projective'\nwidth = {}\nheight = {}\nfx = 224\nfy = 224\ncx "
      "= {}\ncy = 120\n";
  const double centre = (depth.width() - 1) / 2.0;
  for (const std::string set : {"a", "b"}) {
    write_text_file(path(set + "/dataset.toml"),
                    fmt::format(fmt::runtime(toml), depth.width(), depth.height(), centre));
    write_png(path(set + "/depth/0.png"), set == "a" ? depth : mirrored(depth));
  }
  ASSERT_THAT(run_program({"estimate", "--source", "folder:" + path("a"), "--pipeline", path("right.toml"),
                           "--out", path("right.txt")}),
              Succeeded());
  ASSERT_THAT(run_program({"estimate", "--source", "folder:" + path("b"), "--pipeline", path("left.toml"),
                           "--out", path("left.txt")}),
              Succeeded());
  std::istringstream right_line(read_lines(path("right.txt"))[1]);
  std::istringstream left_line(read_lines(path("left.txt"))[1]);
  double right_value = 0.0;
  double left_value = 0.0;
  for (int i = 0; right_line >> right_value && left_line >> left_value; ++i) {
    EXPECT_NEAR(left_value, i % 3 == 0 ? depth.width() - 1 - right_value : right_value, 2e-3)
        << "value " << i;
  }
}

}  // namespace
}  // namespace knuckle::testing
