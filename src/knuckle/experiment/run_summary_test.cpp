// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/run_summary.h"

#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using testing::TemporaryFolder;

class RunSummary : public ::testing::Test {
 protected:
  void write(const std::string& text) { write_text_file(path_, text); }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "forest.json";
};

TEST_F(RunSummary, TimesOfAnEstimationAreAddedUp) {
  write(R"({"median_ms": {"segment": 9, "patch": 1.5, "estimate": 2, "refine": 0.25}})");
  EXPECT_EQ(read_inference_ms(path_), 3.75);
}

TEST_F(RunSummary, ASegmentationWithoutTrueMasksHasNoOverlap) {
  write(R"({"median_ms": 4.5, "mask": {"pixel_iou": 0.75}})");
  EXPECT_EQ(read_segmentation_summary(path_).mask_iou, 0.75);
  EXPECT_EQ(read_segmentation_summary(path_).median_ms, 4.5);
  write(R"({"median_ms": 4.5})");
  EXPECT_TRUE(std::isnan(read_segmentation_summary(path_).mask_iou));
}

TEST_F(RunSummary, WhatIsMissingOrOfAnotherKindIsAFaultOfTheFile) {
  const auto is_of_the_file = AllOf(StartsWith(path_.string()), HasSubstr("no summary of a run"));
  for (const char* text :
       {"", "[]", "7", R"({"median_ms": "4"})", R"({"median_ms": {"patch": 1}})",
        R"({"median_ms": 4, "mask": []})", R"({"median_ms": 4, "mask": {"pixel_iou": "a"}})"}) {
    write(text);
    EXPECT_THAT(error_of([&] { read_segmentation_summary(path_); }), is_of_the_file) << text;
    EXPECT_THAT(error_of([&] { read_inference_ms(path_); }), is_of_the_file) << text;
  }
}

}  // namespace
}  // namespace knuckle
