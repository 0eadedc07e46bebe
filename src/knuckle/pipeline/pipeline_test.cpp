// SPDX-License-Identifier: Apache-2.0
// A pipeline put together in code: what each part is given, and what comes out.
#include "knuckle/pipeline/pipeline.h"

#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "knuckle/core/testing.h"
#include "knuckle/pipeline/calibrated_confidence.h"
#include "knuckle/segment/hand_region.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::AllOf;
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
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start,
                       int /*max_hands*/) const override {
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
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    EXPECT_EQ(patch.pixels.width(), patches_.options().size_px);
    return {{{-1.0, -1.0, 0.0}}, {0.5f}};
  }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10}};
};

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

TEST(CalibratedConfidence, IsAMonotoneMapOfTheUnitInterval) {
  EXPECT_EQ(calibrated_confidence(0.0, 1.3, 1.5), 0.0);
  EXPECT_EQ(calibrated_confidence(1.0, -1.3, 1.5), 1.0);
  EXPECT_NEAR(calibrated_confidence(0.3, 0.0, 1.0), 0.3, 1e-12);
  const double logit = 1.3 + 1.5 * std::log(0.7 / 0.3);
  EXPECT_NEAR(calibrated_confidence(0.7, 1.3, 1.5), 1.0 / (1.0 + std::exp(-logit)), 1e-12);
  double before = 0.0;
  for (int i = 1; i < 100; ++i) {
    const double calibrated = calibrated_confidence(0.01 * i, 1.3, 1.5);
    EXPECT_GT(calibrated, before);
    before = calibrated;
  }
}

TEST(PipelineFromParts, CalibratesWhatComesOutAndNothingElse) {
  const HandOptions hand{.sure_confidence = 0.6, .confidence_offset = 1.3, .confidence_slope = 1.5};
  const FrameEstimate result = Pipeline(parts(hand)).estimate(plate(), {.start = Point3(1.0, 2.0, 3.0)});
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_NEAR(result.hands[0].pose.confidence[0], 1.0 / (1.0 + std::exp(-1.3)), 1e-6);
  EXPECT_NEAR(result.hands[0].score, 0.5, 1e-6) << "of what the estimator says";
  EXPECT_EQ(result.status, kUnsure);
}

TEST(PipelineFromParts, PassesTheStartOn) {
  const Point3 start(10.0, -20.0, 480.0);
  const FrameEstimate result = Pipeline(parts()).estimate(plate(), {.start = start});
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

/// Calls all that is measured a hand of one side.
class SidedSegmenter final : public Segmenter {
 public:
  explicit SidedSegmenter(std::optional<HandSide> side) : side_(side) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found = AllSegmenter().segment(frame, start, max_hands);
    for (HandRegion& region : found.hands) region.side = side_;
    return found;
  }

 private:
  std::optional<HandSide> side_;
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
    return patch.geometry.to_image(PatchPoint{-1.0, -1.0, 0.0}).u > 0.5 * kWidth;
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
  EXPECT_EQ(side(0.6, 0.3f), HandSide::left) << "a little likelier a right one, and much surer as a left one";
  EXPECT_EQ(side(0.6, 0.01f), HandSide::right);
  EXPECT_EQ(side(0.97, 0.3f), HandSide::right) << "sure of the side: the other one is not looked at";
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
  const FrameEstimate result = Pipeline(parts({.side = "left"})).estimate(plate());
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].side, HandSide::left);
  EXPECT_EQ(result.hands[0].region.box, (Box{4, 10, 10, 10}));
  EXPECT_NEAR(result.hands[0].pose.joints[0].u, 13.0, 1e-9);  // the mirror image's left is the frame's right
  EXPECT_NEAR(result.hands[0].pose.joints[0].v, 10.0, 1e-9);
}

TEST(PipelineFromParts, MirrorsTheStartOfALeftHandThereAndBack) {
  const Point3 start(-60.0, 10.0, 500.0);
  const FrameEstimate result = Pipeline(parts({.side = "left"})).estimate(plate(), {.start = start});
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_EQ(result.hands[0].region.centre, start);  // the segmenter answers with what it is given
  const FrameEstimate anywhere = Pipeline(parts({.side = "left"})).estimate(plate());
  EXPECT_EQ(anywhere.hands.at(0).region.centre, Point3(-1.0, 2.0, 3.0));  // seen at x = 1 in the mirror
}

TEST(PipelineFromParts, TellsWhyThereIsNoHand) {
  Frame blank = plate();
  std::ranges::fill(blank.depth_mm.pixels(), 0.0f);
  const FrameEstimate result = Pipeline(parts()).estimate(blank);
  EXPECT_TRUE(result.hands.empty());
  EXPECT_EQ(result.status, "nothing there");
}

/// Finds the given columns of the image, as many as are asked for.
class ColumnSegmenter final : public Segmenter {
 public:
  explicit ColumnSegmenter(std::vector<int> columns) : columns_(std::move(columns)) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found;
    for (const int column : columns_) {
      if (std::ssize(found.hands) == max_hands) break;
      const std::vector<std::int32_t> pixels{15 * frame.depth_mm.width() + column};
      HandRegion region = region_of_pixels(pixels, frame.depth_mm.width());
      region.centre = start.value_or(Point3(100.0 * (column - 4) - 250.0, 0.0, 500.0));
      region.score = 0.25;
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
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++calls;
    const double column = patch.geometry.to_image({0.0, 0.0, 0.0}).u;
    const std::vector<float> confidence{static_cast<float>(0.1 * std::round(column))};
    return {{{0.0, 0.0, 0.0}}, has_confidence_ ? confidence : std::vector<float>{}};
  }

  mutable int calls = 0;

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10}};
  bool has_confidence_;
};

Pipeline column_pipeline(std::vector<int> columns, std::unique_ptr<Estimator> estimator) {
  const HandOptions hand{.candidates = 4, .sure_confidence = 0.5};
  return Pipeline(
      {HandFinder(std::make_unique<ColumnSegmenter>(std::move(columns)), hand), std::move(estimator)});
}

std::vector<int> columns_of(const FrameEstimate& found) {
  std::vector<int> columns;
  for (const HandEstimate& hand : found.hands) columns.push_back(hand.region.box.x);
  return columns;
}

struct Candidates {
  std::vector<int> places;  ///< columns that the segmenter finds
  int max_hands;
  std::vector<int> expected;  ///< columns of the hands, surest first
  int calls;                  ///< of the estimator
};

class PipelineCandidates : public ::testing::TestWithParam<Candidates> {};

INSTANTIATE_TEST_SUITE_P(, PipelineCandidates,
                         ::testing::Values(Candidates{{4, 7, 5}, 1, {7}, 3},  // the surest of three
                                           Candidates{{6, 8}, 1, {6}, 1},     // sure: nothing else is tried
                                           Candidates{{4, 6, 8}, 2, {8, 6}, 3},  // two hands
                                           Candidates{{6, 8, 9}, 2, {8, 6}, 2},  // both sure: the surer first
                                           Candidates{{4, 6}, 2, {6}, 2},        // one of two is none
                                           Candidates{{4}, 1, {}, 1},            // nothing is sure
                                           Candidates{{}, 1, {}, 0}));           // nothing is there

TEST_P(PipelineCandidates, AreTriedWhereAPoseIsNotSure) {
  const Candidates& c = GetParam();
  auto estimator = std::make_unique<ColumnEstimator>();
  const ColumnEstimator& seen = *estimator;
  const Pipeline pipeline = column_pipeline(c.places, std::move(estimator));
  EXPECT_EQ(columns_of(pipeline.estimate(plate(), {.max_hands = c.max_hands})), c.expected);
  EXPECT_EQ(seen.calls, c.calls);
}

TEST(PipelineFromParts, TellsTheScoreOfAHand) {
  const FrameEstimate found =
      column_pipeline({4, 7}, std::make_unique<ColumnEstimator>()).estimate(plate(), {.max_hands = 1});
  EXPECT_NEAR(found.hands.at(0).score, 0.7, 1e-6);
  EXPECT_EQ(found.hands.at(0).side, HandSide::right);
  EXPECT_EQ(found.status, "");
}

TEST(PipelineFromParts, FindsNothingWhereNothingIsSure) {
  const Pipeline pipeline = column_pipeline({4}, std::make_unique<ColumnEstimator>());
  const FrameEstimate found = pipeline.estimate(plate(), {.max_hands = 2});
  EXPECT_TRUE(found.hands.empty());
  EXPECT_THAT(found.status, AllOf(HasSubstr("nothing looks like a hand"), HasSubstr("score of 0.40"),
                                  HasSubstr("at least 0.50")));
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

TEST(PipelineFromParts, LooksNowhereElseWhereNotAsked) {
  const Pipeline pipeline = column_pipeline({4, 7}, std::make_unique<ColumnEstimator>());
  const FrameEstimate found = pipeline.estimate(plate(), {.elsewhere = false});
  EXPECT_TRUE(found.hands.empty());
}

TEST(PipelineFromParts, RefusesImpossibleNumbersOfHands) {
  const Pipeline pipeline(parts());
  EXPECT_THAT(error_of([&] { (void)pipeline.estimate(plate(), {.max_hands = 0}); }),
              HasSubstr("max_hands is 0"));
}

/// Looks twice at a cube; the first time it sees the palm at pixel (12, 16), 495 mm away, wherever it looks.
class MovingEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return 2; }
  PatchPose estimate(const HandPatch& patch) const override {
    return {{patch.geometry.to_patch({12.0, 16.0, 495.0})}, {}};
  }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10, .mode = "cube", .cube_mm = 100.0}};
};

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

PipelineParts moving_parts(std::vector<int> columns, int max_hands) {
  return {HandFinder(std::make_unique<ColumnSegmenter>(std::move(columns)), {.max_hands = max_hands}),
          std::make_unique<MovingEstimator>()};
}

/// What another segmenter finds, as likely as it is told.
class LikelySegmenter final : public Segmenter {
 public:
  explicit LikelySegmenter(std::optional<double> likelihood) : likelihood_(likelihood) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found = AllSegmenter().segment(frame, start, max_hands);
    for (HandRegion& hand : found.hands) hand.likelihood = likelihood_;
    return found;
  }

 private:
  std::optional<double> likelihood_;
};

TEST(PipelineFromParts, AHandIsAsSureAsItsPoseAndByHalfAsItsPlace) {
  const auto score = [](std::optional<double> likelihood) {
    const Pipeline pipeline(
        {HandFinder(std::make_unique<LikelySegmenter>(likelihood), {}), std::make_unique<CornerEstimator>()});
    return pipeline.estimate(plate()).hands.at(0).score;
  };
  EXPECT_DOUBLE_EQ(score(std::nullopt), 0.5);
  EXPECT_DOUBLE_EQ(score(1.0), 0.5);
  EXPECT_DOUBLE_EQ(score(0.25), 0.25);
}

/// Says how likely what it sees is a hand.
class DoubtingEstimator final : public Estimator {
 public:
  explicit DoubtingEstimator(double hand) : hand_(hand) {}
  Convention convention() const override { return corner_.convention(); }
  const PatchExtractor& patches() const override { return corner_.patches(); }
  PatchPose estimate(const HandPatch& patch) const override {
    PatchPose pose = corner_.estimate(patch);
    pose.hand = hand_;
    return pose;
  }

 private:
  CornerEstimator corner_;
  double hand_;
};

TEST(PipelineFromParts, AHandIsAsSureAsThatItIsOne) {
  for (const double likely : {1.0, 0.25, 0.0}) {
    const Pipeline pipeline({HandFinder(std::make_unique<LikelySegmenter>(std::nullopt), {}),
                             std::make_unique<DoubtingEstimator>(likely)});
    EXPECT_DOUBLE_EQ(pipeline.estimate(plate()).hands.at(0).score, 0.5 * likely);
  }
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
    PipelineParts fitting = parts({.side = is_left ? "left" : "right"});
    for (const double angle : {0.3, 0.7, 0.0})
      fitting.refiners.push_back(std::make_unique<FittingRefiner>(angle));
    const Frame frame = plate();
    const FrameEstimate found = Pipeline(std::move(fitting)).estimate(frame);
    ASSERT_EQ(found.hands.size(), 1u);
    const HandEstimate& hand = found.hands.front();
    ASSERT_TRUE(hand.angles);
    EXPECT_EQ((*hand.angles)[HandAngle::ring_pip], 0.7);
    EXPECT_EQ(hand.skeleton, "of 0.7");
    EXPECT_NEAR(hand.score, 0.3 * 0.7 * Pipeline(parts()).estimate(frame).hands.front().score, 1e-9);
    EXPECT_FALSE(Pipeline(parts()).estimate(frame).hands.front().angles);
  }
}

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

TEST(PipelineFromParts, CountsAHandThatTwoPlacesLeadToOnce) {
  const FrameEstimate found = Pipeline(moving_parts({4, 5}, 2)).estimate(plate());
  EXPECT_EQ(found.hands.size(), 1u);
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

/// Sees two joints, the second without confidence.
class DoubtfulEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"two2", kTwo}; }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& /*patch*/) const override {
    return {{{0.0, 0.0, 0.0}, {0.5, 0.0, 0.0}}, {0.9f, 0.3f}};
  }

 private:
  static constexpr std::array kTwo = {Landmark::palm, Landmark::wrist};
  PatchExtractor patches_{{.size_px = 10}};
};

TEST(PipelineFromParts, AScoreIsTheMeanConfidence) {
  const Pipeline pipeline(
      {HandFinder(std::make_unique<AllSegmenter>()), std::make_unique<DoubtfulEstimator>()});
  EXPECT_NEAR(pipeline.estimate(plate()).hands.at(0).score, 0.6, 1e-6);
}

/// Finds a hand at each of these places [mm].
class PlaceSegmenter final : public Segmenter {
 public:
  explicit PlaceSegmenter(std::vector<double> places) : places_(std::move(places)) {}
  Segmentation segment(const Frame& frame, const std::optional<Point3>& start, int max_hands) const override {
    Segmentation found = AllSegmenter().segment(frame, start, max_hands);
    const HandRegion region = found.hands.front();
    found.hands.clear();
    for (const double x : places_) {
      if (std::ssize(found.hands) == max_hands) break;
      found.hands.push_back(region);
      found.hands.back().centre = Point3(x, 0.0, 500.0);
    }
    return found;
  }

 private:
  std::vector<double> places_;
};

TEST(PipelineFromParts, PlacesNearerThanFiftyMillimetresAreOneHand) {
  const auto hands_at = [](std::vector<double> places) {
    const Pipeline pipeline(
        {HandFinder(std::make_unique<PlaceSegmenter>(std::move(places)), {.max_hands = 3}),
         std::make_unique<CornerEstimator>()});
    return pipeline.estimate(plate()).hands.size();
  };
  EXPECT_EQ(hands_at({0.0, 49.0}), 1u);
  EXPECT_EQ(hands_at({0.0, 51.0}), 2u);
  EXPECT_EQ(hands_at({0.0, 51.0, 25.0}), 2u);
}

TEST(PipelineFromParts, DoesNotDoubtAMethodWithoutConfidence) {
  const Pipeline pipeline = column_pipeline({4, 7}, std::make_unique<ColumnEstimator>(false));
  const FrameEstimate found = pipeline.estimate(plate());
  EXPECT_EQ(columns_of(found), std::vector{4});
  EXPECT_EQ(found.hands.at(0).score, 1.0);
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
