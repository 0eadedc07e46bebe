// SPDX-License-Identifier: Apache-2.0
// Which side a hand is looked at as: what is told, what an estimator says, what is found in the mirror.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "knuckle/pipeline/pipeline_testing.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/detector/side_network.h"

namespace knuckle {
namespace {

using testing::AllSegmenter;
using testing::ColumnEstimator;
using testing::columns_of;
using testing::ColumnSegmenter;
using testing::corner_parts;
using testing::CornerEstimator;
using testing::plate;

/// Calls all that is measured a hand of one side.
class SidedSegmenter final : public Segmenter {
 public:
  explicit SidedSegmenter(std::optional<HandSide> side, std::optional<double> right_hand = {})
      : side_(side), right_hand_(right_hand) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found = AllSegmenter().segment(frame, start, max_hands);
    for (HandRegion& region : found.hands) {
      region.side = side_;
      region.right_hand = right_hand_;
    }
    return found;
  }

 private:
  std::optional<HandSide> side_;
  std::optional<double> right_hand_;
};

TEST(PipelineFromParts, LooksAtEachHandAsTheSideThatSegmentationTells) {
  for (const std::string side : {"auto", "right"}) {
    for (const auto told :
         {std::optional<HandSide>(), std::optional(HandSide::right), std::optional(HandSide::left)}) {
      PipelineParts sided{HandFinder(std::make_unique<SidedSegmenter>(told), {.side = side}),
                          std::make_unique<CornerEstimator>()};
      const FrameEstimate result = Pipeline(std::move(sided)).estimate(plate());
      ASSERT_EQ(result.hands.size(), 1u);
      const HandEstimate& hand = result.hands[0];
      const bool is_left = side == "auto" && told == HandSide::left;
      EXPECT_EQ(hand.side, is_left ? HandSide::left : HandSide::right);
      EXPECT_NEAR(hand.pose.joints[0].u, is_left ? 13.0 : 4.0, 1e-9);
      EXPECT_EQ(hand.region.box.x, 4);
      EXPECT_EQ(hand.region.side, told);
    }
  }
}

/// Tells a right hand by its side of the image: `right_in_left_half` where the plate is, and in a mirror the
/// rest.
class SideEstimator final : public Estimator {
 public:
  /// In a mirror it is surer of the pose by `surer`.
  explicit SideEstimator(std::optional<double> right_hand, float surer = 0.0f)
      : right_hand_(right_hand), surer_(surer) {}
  Convention convention() const override { return corner_.convention(); }
  const PatchExtractor& patches() const override { return corner_.patches(); }
  PatchPose estimate(const HandPatch& patch) const override {
    PatchPose pose = corner_.estimate(patch);
    if (right_hand_) pose.right_hand = is_mirrored(patch) ? 1.0 - *right_hand_ : *right_hand_;
    if (is_mirrored(patch)) pose.confidence.front() += surer_;
    return pose;
  }

 private:
  /// The plate lies in the left half of the frame.
  static bool is_mirrored(const HandPatch& patch) {
    return patch.geometry.to_image(PatchPoint{-1.0, -1.0, 0.0}).u > 0.5 * testing::kPlateFrameWidth;
  }

  CornerEstimator corner_;
  std::optional<double> right_hand_;
  float surer_;
};

TEST(PipelineFromParts, WhereNobodyIsSureOfTheSideTheSurerPoseCounts) {
  const auto side = [](std::optional<double> right, float surer) {
    PipelineParts parts{HandFinder(std::make_unique<SidedSegmenter>(HandSide::right), {.side = "auto"}),
                        std::make_unique<SideEstimator>(right, surer)};
    return Pipeline(std::move(parts)).estimate(plate()).hands.at(0).side;
  };
  EXPECT_EQ(side(std::nullopt, 0.2f), HandSide::left);
  EXPECT_EQ(side(std::nullopt, -0.2f), HandSide::right);
  EXPECT_EQ(side(0.52, 0.3f), HandSide::left)
      << "a little likelier a right one, and much surer as a left one";
  EXPECT_EQ(side(0.6, 0.01f), HandSide::right);
}

TEST(PipelineFromParts, WhoSeesTheArmAndWhoSeesTheHandTellTheSideTogether) {
  const auto seen = [](double by_the_arm, std::optional<double> by_the_hand) {
    const HandSide guess = by_the_arm >= 0.5 ? HandSide::right : HandSide::left;
    PipelineParts parts{HandFinder(std::make_unique<SidedSegmenter>(guess, by_the_arm), {.side = "auto"}),
                        std::make_unique<SideEstimator>(by_the_hand)};
    return Pipeline(std::move(parts)).estimate(plate()).hands.at(0);
  };
  // Odds are multiplied: 4 (0.8) and 1 / 9 (0.1) are 4 / 9 for a right hand, 9 / 13 for a left one.
  EXPECT_EQ(seen(0.8, 0.1).side, HandSide::left);
  EXPECT_NEAR(seen(0.8, 0.1).side_confidence.value(), 9.0 / 13.0, 1e-9);
  EXPECT_EQ(seen(0.95, 0.1).side, HandSide::right) << "19 / 9";
  EXPECT_NEAR(seen(0.95, 0.1).side_confidence.value(), 19.0 / 28.0, 1e-9);
  EXPECT_EQ(seen(0.1, 0.8).side, HandSide::left);
  EXPECT_EQ(seen(0.3, std::nullopt).side, HandSide::left) << "the hand alone tells nothing";
  EXPECT_NEAR(seen(0.3, std::nullopt).side_confidence.value(), 0.7, 1e-9);
}

/// Knows the side only when other looks are asked for: a left one, with this likelihood.
class AskedForSide final : public Estimator {
 public:
  /// Says `at_first` of a right hand, where it was not asked.
  explicit AskedForSide(int* asked, double left = 0.7, std::optional<double> at_first = {})
      : sees_(left), first_(at_first), asked_(asked) {}
  Convention convention() const override { return sees_.convention(); }
  const PatchExtractor& patches() const override { return sees_.patches(); }
  PatchPose estimate(const HandPatch& patch) const override { return first_.estimate(patch); }
  PatchPose sided(const HandPatch& patch, PatchPose seen) const override {
    ++*asked_;
    seen.right_hand = 1.0 - *sees_.estimate(patch).right_hand;
    return seen;
  }

 private:
  SideEstimator sees_;
  SideEstimator first_;
  int* asked_;
};

TEST(PipelineFromParts, OtherLooksTellTheSideWhereItIsNotKnown) {
  int asked = 0;
  const auto side = [&](HandOptions hand, std::optional<HandSide> known = {}) {
    asked = 0;
    PipelineParts parts{HandFinder(std::make_unique<SidedSegmenter>(HandSide::right), std::move(hand)),
                        std::make_unique<AskedForSide>(&asked)};
    const Search search{.start = Point3(1.0, 2.0, 3.0), .side = known};
    return Pipeline(std::move(parts)).estimate(plate(), search).hands.at(0).side;
  };
  EXPECT_EQ(side({.side = "auto"}), HandSide::left);
  EXPECT_EQ(asked, 2) << "of both sides";
  EXPECT_EQ(side({.side = "auto"}, HandSide::right), HandSide::right);
  EXPECT_EQ(asked, 0) << "it is known";
  EXPECT_EQ(side({.side = "right"}), HandSide::right);
  EXPECT_EQ(asked, 0) << "it is said";
  side({.side = "auto", .sure_confidence = 0.9});
  EXPECT_EQ(asked, 0) << "it is no hand anyway";
}

TEST(PipelineFromParts, WhereTheSideIsClearTheOtherOneIsNotLookedAt) {
  const auto sides_seen = [](double left, HandSide guess) {
    int asked = 0;
    PipelineParts parts{HandFinder(std::make_unique<SidedSegmenter>(guess), {.side = "auto"}),
                        std::make_unique<AskedForSide>(&asked, left)};
    EXPECT_EQ(Pipeline(std::move(parts)).estimate(plate()).hands.at(0).side, HandSide::left);
    return asked;
  };
  EXPECT_EQ(sides_seen(0.91, HandSide::left), 1);
  EXPECT_EQ(sides_seen(0.89, HandSide::left), 2);
  EXPECT_EQ(sides_seen(0.99, HandSide::right), 2) << "a wrong guess";
}

TEST(PipelineFromParts, WhereArmAndHandAgreeOnTheSideNoOtherLookIsTaken) {
  int asked = 0;
  const auto seen = [&](double right_by_the_arm, std::optional<double> right_by_the_hand) {
    asked = 0;
    const HandSide guess = right_by_the_arm >= 0.5 ? HandSide::right : HandSide::left;
    PipelineParts parts{
        HandFinder(std::make_unique<SidedSegmenter>(guess, right_by_the_arm), {.side = "auto"}),
        std::make_unique<AskedForSide>(&asked, 0.99, right_by_the_hand)};
    return Pipeline(std::move(parts)).estimate(plate()).hands.at(0);
  };
  for (const HandSide side : {HandSide::right, HandSide::left}) {
    const auto as = [&](double right) { return side == HandSide::right ? right : 1.0 - right; };
    EXPECT_EQ(seen(as(0.76), as(0.51)).side, side) << "other looks would say left";
    EXPECT_EQ(asked, 0);
    EXPECT_EQ(seen(as(0.76), std::nullopt).side, side) << "the first look does not tell";
    EXPECT_EQ(asked, 0);
    EXPECT_NEAR(seen(as(0.8), as(0.6)).side_confidence.value(), 6.0 / 7.0, 1e-9) << "odds of 4 and 1.5";
    seen(as(0.76), as(0.49));
    EXPECT_GT(asked, 0) << "the hand looks like one of the other side";
    seen(as(0.74), as(0.9));
    EXPECT_GT(asked, 0) << "the arm is not clear";
  }
}

TEST(PipelineFromParts, ASideThatIsKnownIsNotAsked) {
  for (const HandSide known : {HandSide::right, HandSide::left}) {
    PipelineParts parts{HandFinder(std::make_unique<SidedSegmenter>(HandSide::right), {.side = "auto"}),
                        std::make_unique<SideEstimator>(0.97)};
    const FrameEstimate result =
        Pipeline(std::move(parts)).estimate(plate(), {.max_hands = 1, .side = known});
    ASSERT_EQ(result.hands.size(), 1u);
    EXPECT_EQ(result.hands[0].side, known);
    EXPECT_NEAR(result.hands[0].pose.joints[0].u, known == HandSide::left ? 13.0 : 4.0, 1e-9);
  }
}

TEST(PipelineFromParts, WhoSeesTheArmIsAskedWhereTheSideIsOpen) {
  const auto network = std::make_shared<const SideNetwork>(random_detector(testing::small_detector(), 3));
  const auto right_by_the_arm = [&](const std::optional<Point3>& start, std::optional<HandSide> known) {
    PipelineParts parts{HandFinder(std::make_unique<SidedSegmenter>(std::nullopt), {.side = "auto"}, network),
                        std::make_unique<SideEstimator>(std::nullopt)};
    const FrameEstimate found = Pipeline(std::move(parts)).estimate(plate(), {.start = start, .side = known});
    return found.hands.at(0).region.right_hand;
  };
  for (const auto& start : {std::optional<Point3>(), std::optional(Point3(1.0, 2.0, 3.0))}) {
    EXPECT_TRUE(right_by_the_arm(start, std::nullopt));
    EXPECT_FALSE(right_by_the_arm(start, HandSide::right)) << "it is known";
  }
}

TEST(PipelineFromParts, AnEstimatorThatDoubtsTheSideIsShownTheOtherOne) {
  for (const auto told :
       {std::optional<HandSide>(), std::optional(HandSide::right), std::optional(HandSide::left)}) {
    for (const std::optional<double> right :
         {std::optional<double>(), std::optional(0.9), std::optional(0.2)}) {
      PipelineParts sided{HandFinder(std::make_unique<SidedSegmenter>(told), {.side = "auto"}),
                          std::make_unique<SideEstimator>(right)};
      const FrameEstimate result = Pipeline(std::move(sided)).estimate(plate());
      ASSERT_EQ(result.hands.size(), 1u);
      const HandEstimate& hand = result.hands[0];
      const bool is_left = right ? *right < 0.5 : told == HandSide::left;
      EXPECT_EQ(hand.side, is_left ? HandSide::left : HandSide::right);
      EXPECT_NEAR(hand.pose.joints[0].u, is_left ? 13.0 : 4.0, 1e-9);
      ASSERT_EQ(hand.side_confidence.has_value(), right.has_value());
      if (right) {
        EXPECT_NEAR(*hand.side_confidence, is_left ? 1.0 - *right : *right, 1e-12);
      }
    }
  }
}

TEST(PipelineFromParts, MirrorsALeftHandThereAndBack) {
  const FrameEstimate result = Pipeline(corner_parts({.side = "left"})).estimate(plate());
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].side, HandSide::left);
  EXPECT_EQ(result.hands[0].region.box, (Box{4, 10, 10, 10}));
  EXPECT_NEAR(result.hands[0].pose.joints[0].u, 13.0, 1e-9);  // the mirror image's left is the frame's right
  EXPECT_NEAR(result.hands[0].pose.joints[0].v, 10.0, 1e-9);
}

TEST(PipelineFromParts, MirrorsTheStartOfALeftHandThereAndBack) {
  const Point3 start(-60.0, 10.0, 500.0);
  const FrameEstimate result = Pipeline(corner_parts({.side = "left"})).estimate(plate(), {.start = start});
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].region.centre, start);  // the segmenter answers with what it is given
  const FrameEstimate anywhere = Pipeline(corner_parts({.side = "left"})).estimate(plate());
  EXPECT_EQ(anywhere.hands.at(0).region.centre, Point3(-1.0, 2.0, 3.0));  // seen at x = 1 in the mirror
}

TEST(PipelineFromParts, FindsTwoLeftHands) {
  const HandOptions hand{.side = "left", .candidates = 4, .sure_confidence = 0.5};
  const Pipeline pipeline({HandFinder(std::make_unique<ColumnSegmenter>(std::vector{30, 33}), hand),
                           std::make_unique<ColumnEstimator>()});
  Frame frame = plate();
  std::ranges::fill(frame.depth_mm.pixels(), 500.0f);
  const FrameEstimate found = pipeline.estimate(frame, {.max_hands = 2});
  EXPECT_EQ(columns_of(found), (std::vector{6, 9}));  // 39 - 33, 39 - 30
  for (const HandEstimate& one : found.hands) EXPECT_EQ(one.side, HandSide::left);
}

}  // namespace
}  // namespace knuckle
