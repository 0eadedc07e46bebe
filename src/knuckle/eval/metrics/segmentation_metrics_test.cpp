// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/segmentation_metrics.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/eval/metrics/score_files.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using ::testing::HasSubstr;

HandPose pose_with(const std::vector<ImagePoint>& joints) {
  HandPose pose = HandPose::missing(convention_from_name("icg20"));
  std::ranges::copy(joints, pose.joints.begin());
  return pose;
}

Image<std::uint8_t> mask_of(const Box& box) {
  Image<std::uint8_t> mask(40, 40);
  for (int row = box.y; row < box.bottom(); ++row) {
    for (int column = box.x; column < box.right(); ++column) mask(column, row) = 1;
  }
  return mask;
}

TEST(Overlap, OfBoxesIsThatOfTheirPixels) {
  Random random(1);
  const auto size = [&] { return 1 + static_cast<int>(random.below(15)); };
  for (int i = 0; i < 200; ++i) {
    const Box a{static_cast<int>(random.below(20)), static_cast<int>(random.below(20)), size(), size()};
    const Box b{static_cast<int>(random.below(20)), static_cast<int>(random.below(20)), size(), size()};
    const double overlap = intersection_over_union(a, b);
    EXPECT_NEAR(overlap, mask_intersection_over_union(mask_of(a), mask_of(b)), 1e-12);
    EXPECT_EQ(overlap, intersection_over_union(b, a));
    EXPECT_EQ(intersection_over_union(a, a), 1.0);
  }
}

TEST(Overlap, OfRectanglesIsThatComputedByHand) {
  EXPECT_DOUBLE_EQ(intersection_over_union(Rectangle{0, 0, 2, 2}, Rectangle{1, 1, 3, 3}), 1.0 / 7.0);
  EXPECT_DOUBLE_EQ(intersection_over_union(Rectangle{0, 0, 2, 2}, Rectangle{2, 0, 3, 2}), 0.0);
  EXPECT_DOUBLE_EQ(intersection_over_union(Rectangle{0, 0, 2, 2}, Rectangle{5, 5, 1, 1}), 0.0);
  EXPECT_EQ(intersection_over_union(Box{}, Box{}), 0.0);
}

TEST(Overlap, MasksOfDifferentSizesAreRefused) {
  EXPECT_THAT(error_of([] {
                mask_intersection_over_union({2, 3}, {3, 2});
              }),
              AllOf(HasSubstr("2x3"), HasSubstr("3x2")));
  EXPECT_EQ(mask_intersection_over_union({2, 3}, {2, 3}), 1.0);
}

TEST(TruthRectangle, IsTheSmallestAroundTheKnownJoints) {
  const HandPose pose =
      pose_with({{4.0, 9.0, 500.0}, {kNaN, 0.0, 500.0}, {2.5, 11.0, 500.0}, {7.0, 10.0, 500.0}});
  const std::optional<Rectangle> around = rectangle_around(pose);
  ASSERT_TRUE(around);
  EXPECT_EQ(around->left, 2.5);
  EXPECT_EQ(around->top, 9.0);
  EXPECT_EQ(around->right, 7.0);
  EXPECT_EQ(around->bottom, 11.0);
  EXPECT_FALSE(rectangle_around(pose_with({})));
}

TEST(SegmentationScore, CountsMissingHandsAsFailures) {
  const HandPose hand =
      pose_with({{9.5, 19.5, 500.0}, {19.5, 39.5, 500.0}});  // covers columns 10-19, rows 20-39
  const std::vector<HandPose> truth = {hand, hand, hand, pose_with({})};
  const std::vector<Box> boxes = {{10, 20, 10, 20}, {10, 20, 10, 10}, {}, {0, 0, 5, 5}};
  const SegmentationScore score = score_boxes("threshold", boxes, truth);
  EXPECT_EQ(score.frames, 3);
  EXPECT_EQ(score.missing, 1);
  EXPECT_DOUBLE_EQ(score.mean_iou, 0.5);
  EXPECT_DOUBLE_EQ(score.median_iou, 0.5);
  EXPECT_DOUBLE_EQ(score.fraction_above[0], 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(score.fraction_above[49], 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(score.fraction_above[50], 1.0 / 3.0);  // r > t, not >=
  EXPECT_DOUBLE_EQ(score.fraction_above[100], 0.0);
  EXPECT_TRUE(std::ranges::is_sorted(score.fraction_above, std::ranges::greater{}));
}

TEST(SegmentationScore, RefusesWhatCannotBeScored) {
  const std::vector<HandPose> truth = {pose_with({})};
  EXPECT_THAT(error_of([&] { score_boxes("m", std::vector<Box>(2), truth); }),
              AllOf(HasSubstr("2 boxes"), HasSubstr("1 frames")));
  EXPECT_THAT(error_of([&] { score_boxes("m", std::vector<Box>(1), truth); }), HasSubstr("no frame"));
}

TEST(ScoreFiles, HoldTheCurveOfOverlapsAtItsOwnThresholds) {
  std::vector<double> overlaps;  // of 80 frames, so that each threshold has another share
  for (int i = 20; i < 100; ++i) overlaps.push_back(0.01 * i + 0.005);
  const std::vector<SegmentationScore> scores{score_overlaps("forest", overlaps, 3)};
  const nlohmann::json json = nlohmann::json::parse(to_json(std::nullopt, scores))["segmentation"][0];
  EXPECT_EQ(json["name"], "forest");
  EXPECT_EQ(json["frames"], 80);
  EXPECT_EQ(json["missing"], 3);
  EXPECT_DOUBLE_EQ(json["fraction_above"]["0.50"].get<double>(), 50.0 / 80.0);
  EXPECT_DOUBLE_EQ(json["fraction_above"]["0.75"].get<double>(), 25.0 / 80.0);
  EXPECT_EQ(json["fraction_above"].size(), 2U);
  const std::string csv = overlaps_csv(scores);
  EXPECT_THAT(csv, ::testing::StartsWith("method,threshold,frames_above\nforest,0.00,1.000000\n"));
  EXPECT_THAT(csv, ::testing::HasSubstr("\nforest,0.50,0.625000\n"));
  EXPECT_THAT(csv, ::testing::HasSubstr("\nforest,0.90,0.125000\n"));
}

}  // namespace
}  // namespace knuckle
