// SPDX-License-Identifier: Apache-2.0
// Where a hand is looked for that has a start.
#include <array>
#include <cmath>

#include "knuckle/pipeline/pipeline_testing.h"

namespace knuckle {
namespace {

using testing::AllSegmenter;
using testing::column_pipeline;
using testing::ColumnEstimator;
using testing::columns_of;
using testing::corner_parts;
using testing::plate;

TEST(PipelineFromParts, PassesTheStartOn) {
  const Point3 start(10.0, -20.0, 480.0);
  const FrameEstimate result = Pipeline(corner_parts()).estimate(plate(), {.start = start});
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].region.centre, start);
}

TEST(PipelineFromParts, TrustsAGivenStart) {
  auto estimator = std::make_unique<ColumnEstimator>();
  const ColumnEstimator& seen = *estimator;
  const Pipeline pipeline = column_pipeline({4, 7, 8}, std::move(estimator));
  const Point3 start(1.0, 2.0, 500.0);
  const FrameEstimate found = pipeline.estimate(plate(), {.start = start, .max_hands = 2});
  EXPECT_EQ(columns_of(found), std::vector{4});
  EXPECT_EQ(found.hands.at(0).region.centre, start);
  EXPECT_EQ(found.status, kUnsure);
  EXPECT_EQ(seen.calls, 1);
}

/// Is surer the nearer the middle of the cube that it sees is to column 9 of the image.
class CubeEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    const double off = std::abs(patch.geometry.centre_u - 9.0);
    return {{{0.0, 0.0, 0.0}}, {static_cast<float>(0.6 - 0.1 * off)}};
  }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10, .mode = "cube", .cube_mm = 100.0}};
};

/// Leaves its start for what lies three columns to the right of it.
class StrayingSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found = AllSegmenter().segment(frame, start, max_hands);
    for (HandRegion& region : found.hands) region.centre.x() += 3.0 * 500.0 / 30.0;
    return found;
  }
};

TEST(PipelineFromParts, LooksAtTheStartItselfWhereSegmentationLeftItForWhatIsNotSure) {
  const HandOptions hand{.sure_confidence = 0.5};
  const Pipeline pipeline(
      {HandFinder(std::make_unique<StrayingSegmenter>(), hand), std::make_unique<CubeEstimator>()});
  const auto column = [](double u) { return Point3((u - 19.5) * 500.0 / 30.0, 0.0, 500.0); };
  const auto score_from = [&](double u) {
    return pipeline.estimate(plate(), {.start = column(u)}).hands.at(0).score;
  };
  EXPECT_NEAR(score_from(9.0), 0.6, 1e-6);   // where segmentation led to: 0.3
  EXPECT_NEAR(score_from(6.5), 0.55, 1e-6);  // sure there: the start (0.35) is not looked at
  EXPECT_NEAR(score_from(7.0), 0.5, 1e-6);   // at column 10
  EXPECT_NEAR(score_from(4.0), 0.4, 1e-6);   // at column 7; 0.1 at the start
}

TEST(PipelineFromParts, KeepsWhatIsSureEvenIfTheStartWereSurer) {
  const Pipeline pipeline({HandFinder(std::make_unique<StrayingSegmenter>(), {.sure_confidence = 0.3}),
                           std::make_unique<CubeEstimator>()});
  const Point3 at_column_8((8.0 - 19.5) * 500.0 / 30.0, 0.0, 500.0);
  const FrameEstimate found = pipeline.estimate(plate(), {.start = at_column_8});
  EXPECT_NEAR(found.hands.at(0).score, 0.4, 1e-6);  // at column 11, where segmentation led to
}

TEST(PipelineFromParts, IsSureOfAStartWhoseScoreIsHigh) {
  const Pipeline pipeline = column_pipeline({6, 8}, std::make_unique<ColumnEstimator>());
  const FrameEstimate found = pipeline.estimate(plate(), {.start = Point3(1.0, 2.0, 500.0)});
  EXPECT_EQ(columns_of(found), std::vector{6});
  EXPECT_EQ(found.status, "");
}

TEST(PipelineFromParts, LooksBesideTheStartWhereAsked) {
  const Pipeline pipeline = column_pipeline({4, 7, 8}, std::make_unique<ColumnEstimator>());
  const Point3 start(-1000.0, 2.0, 500.0);
  const FrameEstimate two = pipeline.estimate(plate(), {.start = start, .elsewhere = true, .max_hands = 2});
  EXPECT_EQ(columns_of(two), (std::vector{8, 7}));
  EXPECT_EQ(two.status, "");
  const FrameEstimate three = pipeline.estimate(plate(), {.start = start, .elsewhere = true, .max_hands = 3});
  EXPECT_EQ(columns_of(three), (std::vector{8, 7, 4}));  // what is at the start stays, also unsure
}

}  // namespace
}  // namespace knuckle
