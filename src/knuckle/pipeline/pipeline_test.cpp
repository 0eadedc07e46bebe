// SPDX-License-Identifier: Apache-2.0
// A pipeline put together in code: what each part is given, and what comes out.
#include "knuckle/pipeline/pipeline.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "knuckle/pipeline/pipeline_testing.h"

namespace knuckle {
namespace {

using testing::AllSegmenter;
using testing::corner_parts;
using testing::error_of;
using ::testing::HasSubstr;
using testing::moving_parts;
using testing::plate;

TEST(PipelineFromParts, SegmentsCropsAndEstimates) {
  const Pipeline pipeline(corner_parts());
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

/// Changes the palm's depth.
class DepthRefiner final : public Refiner {
 public:
  explicit DepthRefiner(std::function<double(double)> change) : change_(std::move(change)) {}
  RefinedHand refine(const Frame&, const HandRegion&, HandPose pose) const override {
    pose.joints.front().depth_mm = change_(pose.joints.front().depth_mm);
    return {std::move(pose)};
  }

 private:
  std::function<double(double)> change_;
};

TEST(PipelineFromParts, RefinesInTheOrderOfTheParts) {
  PipelineParts refined = corner_parts();
  refined.refiners.push_back(std::make_unique<DepthRefiner>([](double depth) { return depth + 1.0; }));
  refined.refiners.push_back(std::make_unique<DepthRefiner>([](double depth) { return depth * 2.0; }));
  const FrameEstimate result = Pipeline(std::move(refined)).estimate(plate());
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_NEAR(result.hands[0].pose.joints[0].depth_mm, 1000.0, 1e-3);
}

TEST(PipelineFromParts, TellsWhyThereIsNoHand) {
  Frame blank = plate();
  std::ranges::fill(blank.depth_mm.pixels(), 0.0f);
  const FrameEstimate result = Pipeline(corner_parts()).estimate(blank);
  EXPECT_TRUE(result.hands.empty());
  EXPECT_EQ(result.status, "nothing there");
}

TEST(PipelineFromParts, RefusesImpossibleNumbersOfHands) {
  const Pipeline pipeline(corner_parts());
  EXPECT_THAT(error_of([&] { (void)pipeline.estimate(plate(), {.max_hands = 0}); }),
              HasSubstr("max_hands is 0"));
}

/// Fits a skeleton, as it says, and lowers the first joint by 1 mm.
class FittingRefiner final : public Refiner {
 public:
  explicit FittingRefiner(double angle) : angle_(angle) {}
  RefinedHand refine(const Frame&, const HandRegion&, HandPose pose) const override {
    pose.joints.front().depth_mm += 1.0;
    RefinedHand hand{std::move(pose)};
    if (angle_ > 0.0) {
      hand.plausibility = angle_;
      hand.angles.emplace()[HandAngle::ring_pip] = angle_;
      hand.skeleton = fmt::format("of {:.1f}", angle_);
    }
    return hand;
  }

 private:
  double angle_;
};

TEST(PipelineFromParts, HandsHaveTheAnglesOfTheLastRefinerThatFitsASkeleton) {
  for (const bool is_left : {false, true}) {
    PipelineParts fitting = corner_parts({.side = is_left ? "left" : "right"});
    for (const double angle : {0.3, 0.7, 0.0})
      fitting.refiners.push_back(std::make_unique<FittingRefiner>(angle));
    const Frame frame = plate();
    const FrameEstimate found = Pipeline(std::move(fitting)).estimate(frame);
    ASSERT_EQ(found.hands.size(), 1u);
    const HandEstimate& hand = found.hands.front();
    ASSERT_TRUE(hand.angles);
    EXPECT_EQ((*hand.angles)[HandAngle::ring_pip], 0.7);
    EXPECT_EQ(hand.skeleton, "of 0.7");
    EXPECT_NEAR(hand.score,
                std::sqrt(0.3 * 0.7) * Pipeline(corner_parts()).estimate(frame).hands.front().score, 1e-9);
    EXPECT_FALSE(Pipeline(corner_parts()).estimate(frame).hands.front().angles);
  }
}

/// Keeps the region that it is given.
class RegionRefiner final : public Refiner {
 public:
  explicit RegionRefiner(HandRegion& seen) : seen_(seen) {}
  RefinedHand refine(const Frame& /*frame*/, const HandRegion& hand, HandPose pose) const override {
    seen_ = hand;
    return {std::move(pose)};
  }

 private:
  HandRegion& seen_;
};

TEST(PipelineFromParts, GivesRefinersTheRegionOfTheLastLook) {
  HandRegion seen;
  PipelineParts moving = moving_parts({4}, 1);
  moving.refiners.push_back(std::make_unique<RegionRefiner>(seen));
  const FrameEstimate found = Pipeline(std::move(moving)).estimate(plate());
  ASSERT_EQ(found.hands.size(), 1u) << found.status;
  // The cube around (12, 16) at 495 mm reaches 3.03 px and 50 mm: columns 9 to 13 of the plate, rows 13
  // to 19.
  EXPECT_EQ(seen.box, (Box{9, 13, 5, 7}));
  EXPECT_NEAR(seen.centre.z(), 495.0, 1e-9);
  EXPECT_NEAR(seen.centre.x(), (12.0 - 19.5) * 495.0 / 30.0, 1e-9);
  EXPECT_EQ(found.hands[0].region.box, seen.box);
  EXPECT_EQ(seen.score, 0.25) << "what segmentation said of it";
}

TEST(PipelineFromParts, SaysWhichPartIsMissing) {
  EXPECT_THAT(error_of([] { HandFinder finder(nullptr); }), HasSubstr("without a segmenter"));
  EXPECT_THAT(error_of([] {
                PipelineParts without = corner_parts();
                without.estimator = nullptr;
                Pipeline pipeline(std::move(without));
              }),
              HasSubstr("without an estimator"));
  EXPECT_THAT(error_of([] {
                PipelineParts without = corner_parts();
                without.refiners.push_back(nullptr);
                Pipeline pipeline(std::move(without));
              }),
              HasSubstr("refiners is missing"));
  EXPECT_THAT(error_of([] { HandFinder finder(std::make_unique<AllSegmenter>(), {.side = "both"}); }),
              HasSubstr("side"));
}

}  // namespace
}  // namespace knuckle
