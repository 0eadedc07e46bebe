// SPDX-License-Identifier: Apache-2.0
// How sure a hand is: of its pose, of its place, of being a hand.
#include <array>
#include <cmath>
#include <optional>

#include "knuckle/pipeline/pipeline_testing.h"

namespace knuckle {
namespace {

using testing::AllSegmenter;
using testing::corner_parts;
using testing::CornerEstimator;
using testing::plate;

TEST(PipelineFromParts, CalibratesWhatComesOutAndNothingElse) {
  const HandOptions hand{.sure_confidence = 0.6, .confidence_offset = 1.3, .confidence_slope = 1.5};
  const FrameEstimate result =
      Pipeline(corner_parts(hand)).estimate(plate(), {.start = Point3(1.0, 2.0, 3.0)});
  ASSERT_EQ(result.hands.size(), 1u);
  EXPECT_NEAR(result.hands[0].pose.confidence[0], 1.0 / (1.0 + std::exp(-1.3)), 1e-6);
  EXPECT_NEAR(result.hands[0].score, 0.5, 1e-6) << "of what the estimator says";
  EXPECT_EQ(result.status, kUnsure);
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

TEST(PipelineFromParts, WhetherItIsAHandCountsAsMuchAsAskedFor) {
  const auto score = [](double likely, double weight) {
    const HandOptions hand{.hand_weight = weight};
    const Pipeline pipeline({HandFinder(std::make_unique<LikelySegmenter>(std::nullopt), hand),
                             std::make_unique<DoubtingEstimator>(likely)});
    return pipeline.estimate(plate()).hands.at(0).score;
  };
  EXPECT_DOUBLE_EQ(score(0.25, 0.5), 0.25);
  EXPECT_DOUBLE_EQ(score(0.0625, 0.25), 0.25);
  EXPECT_DOUBLE_EQ(score(0.25, 0.0), 0.5);
  EXPECT_DOUBLE_EQ(score(0.0, 0.0), 0.5);
  EXPECT_DOUBLE_EQ(score(0.0, 0.125), 0.0);
  EXPECT_THROW(score(0.5, -0.1), Error);
  EXPECT_THROW(score(0.5, 1.1), Error);
}

/// Says how likely it is a hand when it is asked, a quarter, or `at_once`.
class AskedEstimator final : public Estimator {
 public:
  AskedEstimator(std::optional<double> at_once, int* asked) : at_once_(at_once), asked_(asked) {}
  Convention convention() const override { return corner_.convention(); }
  const PatchExtractor& patches() const override { return corner_.patches(); }
  PatchPose estimate(const HandPatch& patch) const override {
    PatchPose pose = corner_.estimate(patch);
    pose.hand = at_once_;
    return pose;
  }
  PatchPose judged(const HandPatch& patch, PatchPose seen) const override {
    ++*asked_;
    EXPECT_EQ(patch.pixels.width(), patches().options().size_px);
    EXPECT_EQ(seen.hand, at_once_);
    seen.hand = 0.25;
    return seen;
  }

 private:
  CornerEstimator corner_;
  std::optional<double> at_once_;
  int* asked_;
};

TEST(PipelineFromParts, OnlyWhatMayBeAHandAndIsNotSurelyOneIsJudged) {
  int asked = 0;
  const auto score = [&](double sure_confidence, double judged_below, std::optional<double> at_once = {}) {
    const HandOptions hand{.sure_confidence = sure_confidence, .judged_below = judged_below};
    const Pipeline pipeline({HandFinder(std::make_unique<LikelySegmenter>(std::nullopt), hand),
                             std::make_unique<AskedEstimator>(at_once, &asked)});
    return pipeline.estimate(plate(), {.start = Point3(1.0, 2.0, 3.0)}).hands.at(0).score;
  };
  EXPECT_DOUBLE_EQ(score(0.0, 0.0), 0.5) << "never, unless the file says so";
  EXPECT_DOUBLE_EQ(score(0.0, 0.5), 0.5) << "it is sure enough";
  EXPECT_DOUBLE_EQ(score(0.51, 1.0), 0.5) << "it is no hand anyway";
  EXPECT_EQ(asked, 0);
  EXPECT_DOUBLE_EQ(score(0.1, 0.51), 0.5 * 0.25);
  EXPECT_EQ(asked, 1);
  EXPECT_DOUBLE_EQ(score(0.0, 1.0, 0.75), 0.5 * 0.25) << "the last word counts";
  EXPECT_EQ(asked, 2);
  EXPECT_THROW(score(0.0, -0.1), Error);
  EXPECT_THROW(score(0.0, 1.1), Error);
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

/// Sees the palm in the corner, and at another look in the middle, less surely.
class AscertainingEstimator final : public Estimator {
 public:
  explicit AscertainingEstimator(int* asked) : asked_(asked) {}
  Convention convention() const override { return corner_.convention(); }
  const PatchExtractor& patches() const override { return corner_.patches(); }
  PatchPose estimate(const HandPatch& patch) const override { return corner_.estimate(patch); }
  PatchPose ascertained(const HandPatch& patch, PatchPose seen) const override {
    ++*asked_;
    EXPECT_EQ(patch.pixels.width(), patches().options().size_px);
    EXPECT_EQ(seen.joints.at(0).u, -1.0);
    return {{{0.0, 0.0, 0.0}}, {0.25f}};
  }

 private:
  CornerEstimator corner_;
  int* asked_;
};

TEST(PipelineFromParts, OnlyWhatMayBeAHandIsAscertained) {
  const auto estimate = [](double sure_confidence, int* asked) {
    const HandOptions hand{.sure_confidence = sure_confidence};
    return Pipeline({HandFinder(std::make_unique<AllSegmenter>(), hand),
                     std::make_unique<AscertainingEstimator>(asked)})
        .estimate(plate(), {.start = Point3(1.0, 2.0, 3.0)});
  };
  int asked = 0;
  const HandEstimate seen_once = estimate(0.51, &asked).hands.at(0);
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(seen_once.pose.confidence[0], 0.5f);
  const HandEstimate seen_twice = estimate(0.5, &asked).hands.at(0);
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(seen_twice.pose.confidence[0], 0.25f);
  EXPECT_GT(seen_twice.pose.joints[0].u, seen_once.pose.joints[0].u);
  EXPECT_DOUBLE_EQ(seen_twice.score, seen_once.score) << "whether it is a hand is decided by the first look";
}

TEST(PipelineFromParts, AScoreIsTheMeanConfidence) {
  const Pipeline pipeline(
      {HandFinder(std::make_unique<AllSegmenter>()), std::make_unique<DoubtfulEstimator>()});
  EXPECT_NEAR(pipeline.estimate(plate()).hands.at(0).score, 0.6, 1e-6);
}

}  // namespace
}  // namespace knuckle
