// SPDX-License-Identifier: Apache-2.0
// Which of the places that segmentation finds become hands.
#include <tuple>

#include "knuckle/camera/projection.h"
#include "knuckle/pipeline/pipeline_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::AllSegmenter;
using testing::column_pipeline;
using testing::ColumnEstimator;
using testing::columns_of;
using testing::ColumnSegmenter;
using testing::CornerEstimator;
using ::testing::HasSubstr;
using testing::kPlateFrameWidth;
using testing::moving_parts;
using testing::plate;

struct Candidates {
  std::vector<int> places;  ///< columns that the segmenter finds
  int max_hands;
  std::vector<int> expected;  ///< columns of the hands, surest first
  int calls;                  ///< of the estimator
};

using Columns = std::vector<int>;

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

TEST(PipelineFromParts, LooksNowhereElseWhereNotAsked) {
  const Pipeline pipeline = column_pipeline({4, 7}, std::make_unique<ColumnEstimator>());
  const FrameEstimate found = pipeline.estimate(plate(), {.elsewhere = false});
  EXPECT_TRUE(found.hands.empty());
}

TEST(PipelineFromParts, CountsAHandThatTwoPlacesLeadToOnce) {
  const FrameEstimate found = Pipeline(moving_parts({4, 5}, 2)).estimate(plate());
  EXPECT_EQ(found.hands.size(), 1u);
}

std::vector<int> known_columns(const FrameEstimate& found) {
  std::vector<int> columns;
  for (const HandRegion& region : found.known) columns.push_back(region.box.x);
  return columns;
}

/// Columns are 100 mm apart, the sixth at x = -50 mm.
TEST(PipelineFromParts, CountsAKnownHandAndDoesNotLookAtIt) {
  const auto search = [](double x, int max_hands) {
    auto estimator = std::make_unique<ColumnEstimator>();
    const ColumnEstimator& seen = *estimator;
    const Pipeline pipeline = column_pipeline({6, 8}, std::move(estimator));
    FrameEstimate found = pipeline.estimate(plate(), {.max_hands = max_hands, .known = {{x, 0.0, 500.0}}});
    return std::tuple{columns_of(found), known_columns(found), seen.calls};
  };
  EXPECT_EQ(search(-50.0, 1), (std::tuple{Columns{}, Columns{6}, 0}));
  EXPECT_EQ(search(-50.0, 2), (std::tuple{Columns{8}, Columns{6}, 1}));
  EXPECT_EQ(search(-129.0, 1), (std::tuple{Columns{}, Columns{6}, 0}));
  EXPECT_EQ(search(-131.0, 1), (std::tuple{Columns{6}, Columns{}, 1}));  // another hand
}

TEST(PipelineFromParts, KnowsALeftHandWhereItIs) {
  const Pipeline pipeline({HandFinder(std::make_unique<ColumnSegmenter>(Columns{6}), {.side = "left"}),
                           std::make_unique<ColumnEstimator>()});
  const FrameEstimate found = pipeline.estimate(plate(), {.known = {{50.0, 0.0, 500.0}}});
  ASSERT_EQ(found.known.size(), 1u);
  EXPECT_EQ(found.known[0].centre.x(), 50.0);
  EXPECT_EQ(found.known[0].box.x, kPlateFrameWidth - 1 - 6);
}

/// Looks up to three times at a cube; sees the palm so far to the right of the middle of each look [mm].
class StepEstimator final : public Estimator {
 public:
  explicit StepEstimator(double step_mm, float confidence = 1.0f)
      : step_mm_(step_mm), confidence_(confidence) {}
  Convention convention() const override { return {"corner1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return 3; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++calls;
    const Projection projection(plate().camera);
    Point3 place = projection.to_camera(patch.geometry.to_image({0.0, 0.0, 0.0}));
    place.x() += step_mm_;
    return {{patch.geometry.to_patch(projection.to_image(place))}, {confidence_}};
  }

  mutable int calls = 0;

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 10, .mode = "cube", .cube_mm = 100.0}};
  double step_mm_;
  float confidence_;
};

TEST(PipelineFromParts, DoesNotLookAgainWhereItHasLooked) {
  const auto looks = [](double step_mm) {
    auto estimator = std::make_unique<StepEstimator>(step_mm);
    const StepEstimator& seen = *estimator;
    const Pipeline pipeline({HandFinder(std::make_unique<AllSegmenter>(), {}), std::move(estimator)});
    pipeline.estimate(plate(), {.start = Point3(-170.0, 0.0, 500.0)});
    return seen.calls;
  };
  EXPECT_EQ(looks(9.0), 1);
  EXPECT_EQ(looks(11.0), 3);
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

class CountingRefiner final : public Refiner {
 public:
  explicit CountingRefiner(int& calls) : calls_(calls) {}
  RefinedHand refine(const Frame&, const HandRegion&, HandPose pose) const override {
    ++calls_;
    return {std::move(pose)};
  }

 private:
  int& calls_;
};

struct Work {
  int looks = 0;
  int refined = 0;
  bool operator==(const Work&) const = default;
};

/// At a place of this confidence, where 0.5 is sure.
Work work_at(float confidence, const std::string& side, const Search& search) {
  Work work;
  auto estimator = std::make_unique<StepEstimator>(11.0, confidence);
  const StepEstimator& seen = *estimator;
  PipelineParts parts{HandFinder(std::make_unique<PlaceSegmenter>(std::vector{-170.0}),
                                 {.side = side, .sure_confidence = 0.5}),
                      std::move(estimator)};
  parts.refiners.push_back(std::make_unique<CountingRefiner>(work.refined));
  const Pipeline pipeline(std::move(parts));
  pipeline.estimate(plate(), search);
  work.looks = seen.calls;
  return work;
}

TEST(PipelineFromParts, GivesUpWhereASearchFoundNoHand) {
  EXPECT_EQ(work_at(0.14f, "right", {}), (Work{1, 0})) << "less than 0.3 of what is sure";
  EXPECT_EQ(work_at(0.16f, "right", {}), (Work{3, 0}));
  EXPECT_EQ(work_at(0.49f, "right", {}), (Work{3, 0}));
  EXPECT_EQ(work_at(0.51f, "right", {}), (Work{3, 1}));
}

TEST(PipelineFromParts, DoesNotGiveUpAtAStartNorBeforeBothSidesWereSeen) {
  // At a start, the place that segmentation found and the start itself are both seen to the end.
  const Search at_start{.start = Point3(-170.0, 0.0, 500.0), .elsewhere = false};
  EXPECT_EQ(work_at(0.14f, "right", at_start), (Work{6, 2}));
  EXPECT_EQ(work_at(0.14f, "auto", {}), (Work{6, 0})) << "both sides are compared, neither is sure";
  EXPECT_EQ(work_at(0.51f, "auto", {}), (Work{6, 1})) << "the one that is kept is refined";
  EXPECT_EQ(work_at(0.14f, "auto", at_start), (Work{12, 2}));
}

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

}  // namespace
}  // namespace knuckle
