// SPDX-License-Identifier: Apache-2.0
// `segment` as a user types it, and what becomes of its boxes.
#include "verbs.h"

#include <filesystem>

#include <nlohmann/json.hpp>

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST_F(VerbsTest, SegmentWritesOneLinePerFrame) {
  ASSERT_THAT(run_program({"segment", "--source", kSixFrames, "--pipeline", "pipelines/free_hand.toml",
                           "--out", path("boxes.csv")}),
              Succeeded());
  const auto lines = read_lines(path("boxes.csv"));
  ASSERT_EQ(lines.size(), 7u);
  EXPECT_EQ(lines[0], "frame,found,x,y,width,height,milliseconds");
  for (std::size_t i = 1; i < lines.size(); ++i)
    EXPECT_THAT(lines[i], StartsWith(std::to_string(i - 1) + ",1,"));
  const std::string options = read_text_file(path("boxes.csv.options.toml"));
  EXPECT_THAT(options, HasSubstr("bandwidth_mm = 13.5"));
  EXPECT_THAT(options, HasSubstr("max_iterations = ")) << "defaults are written too";
}

TEST_F(VerbsTest, ASegmentationForestIsTrainedAndItsBoxesAreScored) {
  write_text_file(path("train.toml"),
                  "source = \"synthetic:" + std::filesystem::absolute("manifests/demo.toml").string() +
                      "?count=20\"\n[forest]\ntrees = 2\nsplits_per_node = 100\noffsets_per_node = 40\n");
  ASSERT_THAT(run_program({"train", "segmentation-forest", "--config", path("train.toml"), "--out",
                           path("forest.model")}),
              Succeeded());
  write_text_file(path("pipeline.toml"), "[segmentation]\nmethod = 'forest'\nmodel = 'forest.model'\n");
  ASSERT_THAT(run_program({"segment", "--source", kSixFrames, "--pipeline", path("pipeline.toml"), "--out",
                           path("boxes.csv"), "--json", path("segment.json")}),
              Succeeded());
  const auto summary = nlohmann::json::parse(read_text_file(path("segment.json")));
  EXPECT_EQ(summary["found"], 6);
  EXPECT_GT(summary["mask"]["mean_iou"], 0.8);

  ASSERT_THAT(
      run_program({"evaluate", "--truth", kSixFrames, "--boxes", "forest=" + path("boxes.csv"), "--boxes",
                   "again=" + path("boxes.csv"), "--json", path("scores.json"), "--out", path("report")}),
      Succeeded());
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_EQ(scores["segmentation"][1]["name"], "again");
  EXPECT_EQ(scores["segmentation"][0]["frames"], 6);
  EXPECT_GT(scores["segmentation"][0]["mean_iou"], 0.5);
  EXPECT_TRUE(std::filesystem::exists(path("report/figures/overlap.svg")));
  EXPECT_THAT(run_program({"evaluate", "--truth", kSixFrames}).error, HasSubstr("nothing to score"));
}

TEST_F(VerbsTest, TheForestFindsThePaintedHandOfARecording) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  ASSERT_THAT(run_program({"segment", "--source", "folder:" + (shared / "real/kinect_hand_mask").string(),
                           "--pipeline", "pipelines/forest_segmentation_wrist.toml", "--out",
                           path("boxes.csv"), "--json", path("scores.json")}),
              Succeeded());
  const auto scores = nlohmann::json::parse(read_text_file(path("scores.json")));
  EXPECT_GT(scores["mask"]["pixel_iou"], 0.90) << "a published forest that was trained on such frames: 0.965";
}

}  // namespace
}  // namespace knuckle::testing
