// SPDX-License-Identifier: Apache-2.0
// A pipeline put together in code: what each part is given, and what comes out.
#include "knuckle/pipeline/pipeline.h"

#include <array>
#include <functional>
#include <utility>

#include "knuckle/core/testing.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

constexpr int kWidth = 40;
constexpr int kHeight = 30;

/// A plate at the left of the image; row 12 is nearer than the others.
Frame plate() {
  Frame frame;
  frame.camera = {.width = kWidth, .height = kHeight, .fx = 30.0, .fy = 30.0, .cx = 19.5, .cy = 14.5};
  frame.depth_mm = Image<float>(kWidth, kHeight);
  for (int row = 10; row < 20; ++row) {
    for (int column = 4; column < 14; ++column) frame.depth_mm(column, row) = row == 12 ? 490.0f : 500.0f;
  }
  return frame;
}

/// Calls all that is measured a hand.
class AllSegmenter final : public Segmenter {
 public:
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start) const override {
    std::vector<std::int32_t> pixels;
    for (std::size_t i = 0; i < frame.depth_mm.size(); ++i) {
      if (is_measured(frame.depth_mm.data()[i])) pixels.push_back(static_cast<std::int32_t>(i));
    }
    if (pixels.empty()) return {{}, "nothing there"};
    HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
    region.centre = start.value_or(Point3(1.0, 2.0, 3.0));
    return {{region}, ""};
  }
};

/// Sees the palm in the upper left corner of every patch, at its mean depth.
class CornerEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchStatistics& patch_statistics() const override { return statistics_; }
  PatchPose estimate(const HandPatch& patch) const override {
    EXPECT_EQ(patch.pixels.width(), statistics_.size_px);
    return {{{-1.0, -1.0, 0.0}}, {0.5f}};
  }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchStatistics statistics_{.size_px = 10, .mean = {}, .whitening = {}};
};

/// Changes the palm's depth.
class DepthRefiner final : public Refiner {
 public:
  explicit DepthRefiner(std::function<double(double)> change) : change_(std::move(change)) {}
  HandPose refine(const Frame&, const HandRegion&, HandPose pose) const override {
    pose.joints.front().depth_mm = change_(pose.joints.front().depth_mm);
    return pose;
  }

 private:
  std::function<double(double)> change_;
};

PipelineParts parts(const HandOptions& hand = {}) {
  return {HandFinder(std::make_unique<AllSegmenter>(), hand), std::make_unique<CornerEstimator>()};
}

TEST(PipelineFromParts, SegmentsCropsAndEstimates) {
  const Pipeline pipeline(parts());
  EXPECT_EQ(pipeline.convention().name, "corner1");
  EXPECT_EQ(pipeline.resolved_options(), "");
  const FrameEstimate result = pipeline.estimate(plate());
  ASSERT_EQ(result.hands.size(), 1u);
  const HandPose& pose = result.hands[0].pose;
  EXPECT_NEAR(pose.joints[0].u, 4.0, 1e-9);
  EXPECT_NEAR(pose.joints[0].v, 10.0, 1e-9);
  EXPECT_NEAR(pose.joints[0].depth_mm, 499.0, 1e-3);  // nine rows at 500, one at 490
  EXPECT_EQ(pose.confidence, std::vector<float>{0.5f});
}

TEST(PipelineFromParts, PassesTheStartOn) {
  const Point3 start(10.0, -20.0, 480.0);
  const FrameEstimate result = Pipeline(parts()).estimate(plate(), start);
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].region.centre, start);
}

TEST(PipelineFromParts, RefinesInTheOrderOfTheParts) {
  PipelineParts refined = parts();
  refined.refiners.push_back(std::make_unique<DepthRefiner>([](double depth) { return depth + 1.0; }));
  refined.refiners.push_back(std::make_unique<DepthRefiner>([](double depth) { return depth * 2.0; }));
  const FrameEstimate result = Pipeline(std::move(refined)).estimate(plate());
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_NEAR(result.hands[0].pose.joints[0].depth_mm, 1000.0, 1e-3);
}

TEST(PipelineFromParts, MirrorsALeftHandThereAndBack) {
  const FrameEstimate result = Pipeline(parts({.side = "left"})).estimate(plate());
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].region.box, (Box{4, 10, 10, 10}));
  EXPECT_NEAR(result.hands[0].pose.joints[0].u, 13.0, 1e-9);  // the mirror image's left is the frame's right
  EXPECT_NEAR(result.hands[0].pose.joints[0].v, 10.0, 1e-9);
}

TEST(PipelineFromParts, TellsWhyThereIsNoHand) {
  Frame blank = plate();
  std::ranges::fill(blank.depth_mm.pixels(), 0.0f);
  const FrameEstimate result = Pipeline(parts()).estimate(blank);
  EXPECT_TRUE(result.hands.empty());
  EXPECT_EQ(result.reason, "nothing there");
}

/// Finds the given columns of the image, or the first of them alone.
class ColumnSegmenter final : public Segmenter {
 public:
  explicit ColumnSegmenter(std::vector<int> columns) : columns_(std::move(columns)) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& /*start*/) const override {
    Segmentation found;
    for (const int column : columns_) {
      const std::vector<std::int32_t> pixels{15 * frame.depth_mm.width() + column};
      HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
      region.centre = Point3(100.0 * column, 0.0, 500.0);
      found.hands.push_back(region);
    }
    return found;
  }

 private:
  std::vector<int> columns_;
};

/// As sure as the column of the patch says: 0.4 in column 4.
class ColumnEstimator final : public Estimator {
 public:
  explicit ColumnEstimator(bool has_confidence = true) : has_confidence_(has_confidence) {}
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchStatistics& patch_statistics() const override { return statistics_; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++calls;
    const double column = patch.geometry.to_image({0.0, 0.0, 0.0}).u;
    const std::vector<float> confidence{static_cast<float>(0.1 * std::round(column))};
    return {{{0.0, 0.0, 0.0}}, has_confidence_ ? confidence : std::vector<float>{}};
  }

  mutable int calls = 0;

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchStatistics statistics_{.size_px = 10, .mean = {}, .whitening = {}};
  bool has_confidence_;
};

struct Candidates {
  std::vector<int> first;
  std::vector<int> others;
  std::vector<int> expected;  ///< columns of the hands, best first
  int calls;                  ///< of the estimator
};

class PipelineCandidates : public ::testing::TestWithParam<Candidates> {};

INSTANTIATE_TEST_SUITE_P(, PipelineCandidates,
                         ::testing::Values(Candidates{{4}, {4, 7, 5}, {7}, 3},  // the surest of three
                                           Candidates{
                                               {6}, {6, 8}, {6}, 1},     // sure: nothing else is looked at
                                           Candidates{{4}, {}, {4}, 1},  // there is nothing else
                                           Candidates{{4, 6}, {4, 6, 8}, {8, 6}, 3},  // two hands
                                           Candidates{{}, {8}, {}, 0}));              // no hand stays none

TEST_P(PipelineCandidates, AreTriedWhereAPoseIsNotSure) {
  const Candidates& c = GetParam();
  auto estimator = std::make_unique<ColumnEstimator>();
  const ColumnEstimator& seen = *estimator;
  const HandOptions hand{.candidates = 4, .sure_confidence = 0.5};
  const Pipeline pipeline({HandFinder(std::make_unique<ColumnSegmenter>(c.first), hand,
                                      std::make_unique<ColumnSegmenter>(c.others)),
                           std::move(estimator)});
  std::vector<int> columns;
  for (const HandEstimate& found : pipeline.estimate(plate()).hands) columns.push_back(found.region.box.x);
  EXPECT_EQ(columns, c.expected);
  EXPECT_EQ(seen.calls, c.calls);
}

TEST(PipelineFromParts, DoesNotDoubtAMethodWithoutConfidence) {
  const Pipeline pipeline({HandFinder(std::make_unique<ColumnSegmenter>(std::vector{4}), {.candidates = 4},
                                      std::make_unique<ColumnSegmenter>(std::vector{4, 7})),
                           std::make_unique<ColumnEstimator>(false)});
  EXPECT_EQ(pipeline.estimate(plate()).hands.at(0).region.box.x, 4);
}

TEST(PipelineFromParts, SaysWhichPartIsMissing) {
  EXPECT_THAT(error_of([] { HandFinder finder(nullptr); }), HasSubstr("without a segmenter"));
  EXPECT_THAT(error_of([] {
                PipelineParts without = parts();
                without.estimator = nullptr;
                Pipeline pipeline(std::move(without));
              }),
              HasSubstr("without an estimator"));
  EXPECT_THAT(error_of([] {
                PipelineParts without = parts();
                without.refiners.push_back(nullptr);
                Pipeline pipeline(std::move(without));
              }),
              HasSubstr("refiners is missing"));
  EXPECT_THAT(error_of([] { HandFinder finder(std::make_unique<AllSegmenter>(), {.side = "both"}); }),
              HasSubstr("side"));
}

}  // namespace
}  // namespace knuckle
