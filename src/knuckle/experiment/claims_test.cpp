// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/claims.h"

#include "knuckle/core/testing.h"

namespace knuckle::testing {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

SegmentationScore overlap(const std::string& name, double mean) {
  SegmentationScore score;
  score.name = name;
  score.mean_iou = mean;
  return score;
}

MethodScore errors(const std::string& name, double mm, double px) {
  MethodScore score;
  score.name = name;
  score.mean_3d_mm = mm;
  score.mean_2d_px = px;
  return score;
}

/// One sequence that bears out everything that the paper says.
SequenceScores as_the_paper_says() {
  SequenceScores scores;
  scores.title = "Sensor";
  scores.segmentation = {overlap("threshold", 0.3), overlap("forest", 0.5), overlap("mean shift", 0.7)};
  scores.segmentation_ms = {1.0, 50.0, 4.0};
  scores.evaluation.emplace();
  scores.evaluation->methods = {errors("forest", 40, 12),      errors("heatmap2d", 30, 8),
                                errors("heatmap25d", 25, 8.1), errors("regression", 20, 7),
                                errors("pca", 20.5, 7),        errors("autoencoder", 18, 6)};
  return scores;
}

std::vector<Verdict> verdicts(const ExperimentScores& scores) {
  std::vector<Verdict> verdicts;
  for (const Claim& claim : scia15_claims(scores)) verdicts.push_back(claim.verdict);
  return verdicts;
}

MethodScore& pose(SequenceScores& scores, std::size_t method) {
  return scores.evaluation->methods.at(method);
}

TEST(ClaimsTest, AllAgreeWhereAllIsAsThePaperSays) {
  const ExperimentScores scores{{as_the_paper_says(), as_the_paper_says()}, {}};
  EXPECT_THAT(verdicts(scores), ::testing::AllOf(::testing::SizeIs(7), Each(Verdict::agrees)));
}

TEST(ClaimsTest, EachIsJudgedByItsOwnNumbers) {
  using enum Verdict;
  const auto after = [](const auto& change) {
    SequenceScores scores = as_the_paper_says();
    change(scores);
    return verdicts({{scores}, {}});
  };
  EXPECT_THAT(after([](auto& s) { s.segmentation[1].mean_iou = 0.8; }),
              ElementsAre(disagrees, agrees, agrees, agrees, agrees, agrees, agrees));
  EXPECT_THAT(after([](auto& s) { s.segmentation_ms[1] = 39.0; }),
              ElementsAre(agrees, disagrees, agrees, agrees, agrees, agrees, agrees));
  EXPECT_THAT(after([](auto& s) { pose(s, 0).mean_3d_mm = 29.0; }),
              ElementsAre(agrees, agrees, disagrees, agrees, agrees, agrees, agrees));
  EXPECT_THAT(after([](auto& s) { pose(s, 2).mean_2d_px = 7.0; }),
              ElementsAre(agrees, agrees, agrees, disagrees, agrees, agrees, agrees));
  EXPECT_THAT(after([](auto& s) { pose(s, 2).mean_3d_mm = 19.0; }),
              ElementsAre(agrees, agrees, agrees, agrees, disagrees, agrees, agrees));
  EXPECT_THAT(after([](auto& s) { pose(s, 4).mean_3d_mm = 18.0; }),
              ElementsAre(agrees, agrees, agrees, agrees, agrees, disagrees, agrees));
  EXPECT_THAT(after([](auto& s) { pose(s, 5).mean_3d_mm = 20.1; }),
              ElementsAre(agrees, agrees, agrees, agrees, agrees, agrees, disagrees));
}

TEST(ClaimsTest, WhatHoldsOnSomeSequencesAgreesInPart) {
  SequenceScores other = as_the_paper_says();
  pose(other, 5).mean_3d_mm = 30.0;
  EXPECT_EQ(verdicts({{as_the_paper_says(), other}, {}}).back(), Verdict::in_part);
}

TEST(ClaimsTest, NamesWhatIsMissing) {
  SequenceScores scores = as_the_paper_says();
  scores.evaluation->methods.resize(5);  // no autoencoder
  scores.segmentation.erase(scores.segmentation.begin());
  scores.segmentation_ms.erase(scores.segmentation_ms.begin());
  const std::vector<Claim> claims = scia15_claims({{scores}, {}});
  EXPECT_EQ(claims.at(0).verdict, Verdict::unknown);
  EXPECT_THAT(claims.at(0).evidence, ElementsAre(HasSubstr("lacks the segmentation \"threshold\"")));
  EXPECT_EQ(claims.at(1).verdict, Verdict::agrees);
  EXPECT_EQ(claims.at(2).verdict, Verdict::unknown);
  EXPECT_THAT(claims.at(6).evidence, ElementsAre(HasSubstr("\"autoencoder\"")));
  scores.evaluation.reset();
  EXPECT_EQ(scia15_claims({{scores}, {}}).at(3).verdict, Verdict::unknown) << "and without any estimation";
}

TEST(ClaimsTest, AnErrorThatIsNotKnownBearsNothingOut) {
  SequenceScores scores = as_the_paper_says();
  pose(scores, 3).mean_3d_mm = kNaN;
  EXPECT_EQ(verdicts({{scores}, {}}).at(4), Verdict::disagrees);
}

}  // namespace
}  // namespace knuckle::testing
