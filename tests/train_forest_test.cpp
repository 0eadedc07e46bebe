// SPDX-License-Identifier: Apache-2.0
// `train pose-forest` and `shrink` as a user types them.
#include "verbs.h"

#include <filesystem>

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(VerbsTest, TrainingMakesAModelThatEstimates) {
  write_text_file(path("train.toml"),
                  "source = 'synthetic:" + std::filesystem::absolute("manifests/demo.toml").string() +
                      "?count=30'\nconvention = 'icg20'\n[forest]\ntrees = 2\nsplits_per_node = 50\n");
  ASSERT_THAT(
      run_program({"train", "pose-forest", "--config", path("train.toml"), "--out", path("forest.model")}),
      Succeeded());
  write_text_file(path("pipeline.toml"), "[estimator]\nmethod = 'forest'\nmodel = 'forest.model'\n");
  ASSERT_THAT(run_program({"estimate", "--source", kSixFrames, "--pipeline", path("pipeline.toml"), "--out",
                           path("poses.txt")}),
              Succeeded());
  EXPECT_THAT(entries_of(folder_.path()), Not(Contains(HasSubstr("checkpoint"))));
}

TEST_F(VerbsTest, TheSameTrainingOnOneAndTwoThreadsMakesTheSameFile) {
  write_text_file(path("train.toml"),
                  "source = 'synthetic:" + std::filesystem::absolute("manifests/demo.toml").string() +
                      "?count=20'\n[forest]\ntrees = 2\nsplits_per_node = 50\n");
  for (const std::string threads : {"1", "2"}) {
    ASSERT_THAT(run_program({"train", "pose-forest", "--config", path("train.toml"), "--out",
                             path("forest" + threads + ".model"), "--threads", threads}),
                Succeeded());
  }
  EXPECT_TRUE(read_text_file(path("forest1.model")) == read_text_file(path("forest2.model")));
}

TEST_F(VerbsTest, AShrunkForestIsSmallerAndEstimates) {
  ASSERT_THAT(run_program({"shrink", "--model", "models/pose_forest.model", "--leaves", "2000", "--leaf-step",
                           "0.1", "--out", path("small.model")}),
              Succeeded());
  EXPECT_LT(std::filesystem::file_size(path("small.model")),
            std::filesystem::file_size("models/pose_forest.model") / 4);
  write_text_file(path("small.toml"),
                  "[patch]\nsize_px = 96\n[estimator]\nmethod = \"forest\"\nmodel = \"small.model\"\n");
  EXPECT_THAT(run_program({"estimate", "--source", kSixFrames, "--pipeline", path("small.toml"), "--out",
                           path("poses.txt")}),
              Succeeded());
  EXPECT_THAT(
      run_program({"shrink", "--model", "models/dense.pt", "--leaves", "9", "--out", path("b.model")}),
      FailedWith("models/dense.pt"));
  EXPECT_FALSE(std::filesystem::exists(path("b.model")));
}

}  // namespace
}  // namespace knuckle::testing
