// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/surest_estimator.h"

#include <array>
#include <cmath>

#include "knuckle/core/angle.h"
#include "knuckle/core/testing.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/patch/turned_patch.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// Always the same pose: its joints say who it was.
class KnownPose final : public Estimator {
 public:
  KnownPose(double name, float confidence, std::optional<double> right_hand, int* asked = nullptr,
            const char* convention = "nyu14", int size_px = 12)
      : name_(name),
        confidence_(confidence),
        right_hand_(right_hand),
        asked_(asked),
        convention_(convention_from_name(convention)),
        patches_({.size_px = size_px, .mode = "cube"}) {}

  Convention convention() const override { return convention_; }
  const PatchExtractor& patches() const override { return patches_; }
  double sure_confidence() const override { return confidence_ < 0.0f ? 0.0 : 0.3; }
  PatchPose estimate(const HandPatch&) const override {
    if (asked_ != nullptr) ++*asked_;
    // Its mean is what counts, not its first.
    return {std::vector<PatchPoint>(14, PatchPoint{name_, 0.0, 0.0}),
            {confidence_ - 0.2f, confidence_ + 0.2f},
            right_hand_,
            right_hand_ ? std::optional(0.5 * *right_hand_) : std::nullopt};
  }

 private:
  double name_;
  float confidence_;
  std::optional<double> right_hand_;
  int* asked_;
  Convention convention_;
  PatchExtractor patches_;
};

PatchPose surest_of(std::vector<std::unique_ptr<Estimator>> estimators,
                    const SurestEstimatorOptions& options = {}) {
  return SurestEstimator(std::move(estimators), options).estimate({});
}

std::vector<std::unique_ptr<Estimator>> three(float first, float second, float third,
                                              int* asked_last = nullptr) {
  std::vector<std::unique_ptr<Estimator>> estimators;
  estimators.push_back(std::make_unique<KnownPose>(1.0, first, std::nullopt));
  estimators.push_back(std::make_unique<KnownPose>(2.0, second, 0.9));
  estimators.push_back(std::make_unique<KnownPose>(3.0, third, 0.2, asked_last));
  return estimators;
}

TEST(SurestEstimator, ThePoseWithTheHighestConfidenceCounts) {
  const SurestEstimatorOptions options{.enough = 1.0, .lead = 0.0};
  EXPECT_EQ(surest_of(three(0.6f, 0.4f, 0.5f), options).joints[0].u, 1.0);
  EXPECT_EQ(surest_of(three(0.4f, 0.6f, 0.5f), options).joints[0].u, 2.0);
  EXPECT_EQ(surest_of(three(0.4f, 0.5f, 0.6f), options).joints[0].u, 3.0);
}

TEST(SurestEstimator, ALaterOneHasToBeSurerByTheLead) {
  EXPECT_EQ(surest_of(three(0.4f, 0.44f, 0.3f), {.lead = 0.05}).joints[0].u, 1.0);
  EXPECT_EQ(surest_of(three(0.4f, 0.46f, 0.3f), {.lead = 0.05}).joints[0].u, 2.0);
  EXPECT_EQ(surest_of(three(0.4f, 0.46f, 0.50f), {.lead = 0.05}).joints[0].u, 2.0);
}

TEST(SurestEstimator, WhatIsSureEnoughAsksNoOther) {
  int asked = 0;
  surest_of(three(0.7f, 0.6f, 0.9f, &asked), {.enough = 0.65});
  surest_of(three(0.3f, 0.7f, 0.9f, &asked), {.enough = 0.65});
  EXPECT_EQ(asked, 0);
  EXPECT_EQ(surest_of(three(0.6f, 0.6f, 0.9f, &asked), {.enough = 0.65}).joints[0].u, 3.0);
  EXPECT_EQ(asked, 1);
  const PatchPose first = surest_of(three(0.3f, 0.7f, 0.9f, &asked), {.enough = 0.0});
  ASSERT_EQ(first.joints.size(), 14u);
  EXPECT_EQ(first.joints[0].u, 1.0) << "one is asked even where nothing is enough";
}

TEST(SurestEstimator, WhoCannotTellTheSideLeavesItToTheOthers) {
  const SurestEstimatorOptions options{.enough = 1.0, .lead = 0.0};
  EXPECT_EQ(surest_of(three(0.6f, 0.5f, 0.4f), options).right_hand, 0.9);
  EXPECT_EQ(surest_of(three(0.4f, 0.5f, 0.6f), options).right_hand, 0.2);
  EXPECT_EQ(surest_of(three(0.7f, 0.5f, 0.4f), {.enough = 0.65}).right_hand, std::nullopt);
  EXPECT_EQ(surest_of(three(0.6f, 0.5f, 0.4f), options).hand, 0.45) << "and whether it is a hand";
  EXPECT_EQ(surest_of(three(0.4f, 0.5f, 0.6f), options).hand, 0.1);
  EXPECT_EQ(surest_of(three(0.7f, 0.5f, 0.4f), {.enough = 0.65}).hand, std::nullopt);
}

TEST(SurestEstimator, TheLastIsAskedWhetherItIsAHandWhereNobodySaid) {
  int asked = 0;
  const SurestEstimator estimator(three(0.7f, 0.6f, 0.9f, &asked), {.enough = 0.65});
  const PatchPose seen = estimator.estimate({});
  ASSERT_EQ(seen.hand, std::nullopt);
  const PatchPose judged = estimator.judged({}, seen);
  EXPECT_EQ(judged.hand, 0.1);
  EXPECT_EQ(judged.right_hand, 0.2);
  EXPECT_EQ(judged.joints[0].u, 1.0) << "the pose stays that of the first";
  EXPECT_EQ(asked, 1);

  PatchPose known = seen;
  known.hand = 0.75;
  EXPECT_EQ(estimator.judged({}, known).hand, 0.75);
  EXPECT_EQ(asked, 1) << "nobody is asked again";
  PatchPose of_known_side = seen;
  of_known_side.right_hand = 0.6;
  EXPECT_EQ(estimator.judged({}, of_known_side).right_hand, 0.6);
}

TEST(SurestEstimator, TheJudgeHasTheLastWordOnTheHandAndNoneOnThePose) {
  int asked_last = 0;
  int asked_judge = 0;
  const SurestEstimator estimator(three(0.4f, 0.6f, 0.5f, &asked_last), {.enough = 0.55},
                                  std::make_unique<KnownPose>(4.0, 0.99f, 0.5, &asked_judge, "nyu14"));
  const PatchPose seen = estimator.estimate({});
  EXPECT_EQ(seen.joints[0].u, 2.0);
  EXPECT_EQ(seen.hand, 0.45);
  EXPECT_EQ(asked_judge, 0) << "however sure it would be";
  const PatchPose judged = estimator.judged({}, seen);
  EXPECT_EQ(judged.hand, 0.25);
  EXPECT_EQ(judged.right_hand, 0.9) << "who was asked for the pose told it";
  EXPECT_EQ(judged.joints[0].u, 2.0);
  EXPECT_EQ(asked_judge, 1);
  EXPECT_EQ(asked_last, 0);
}

TEST(SurestEstimator, TheJudgeSeesPatchesOfTheSameKind) {
  EXPECT_THAT(error_of([] {
                SurestEstimator(three(0.4f, 0.6f, 0.5f), {},
                                std::make_unique<KnownPose>(4.0, 0.9f, 0.5, nullptr, "nyu14", 16));
              }),
              HasSubstr("the judge was trained on patches of another kind"));
}

TEST(SurestEstimator, WhatAnEarlierOneToldIsKept) {
  std::vector<std::unique_ptr<Estimator>> estimators;
  estimators.push_back(std::make_unique<KnownPose>(1.0, 0.4f, 0.8));
  estimators.push_back(std::make_unique<KnownPose>(2.0, 0.6f, std::nullopt));
  const PatchPose pose = surest_of(std::move(estimators));
  EXPECT_EQ(pose.joints[0].u, 2.0);
  EXPECT_EQ(pose.right_hand, 0.8);
  EXPECT_EQ(pose.hand, 0.4);
}

/// Sure of hands whose first pixel is 1 alone, and sees all its joints at the same place of what it is shown.
class KnowsOneWay final : public Estimator {
 public:
  KnowsOneWay(PatchPoint joint, int* asked)
      : joint_(joint), asked_(asked), patches_({.size_px = 12, .mode = "cube"}) {}

  Convention convention() const override { return convention_from_name("nyu14"); }
  const PatchExtractor& patches() const override { return patches_; }
  double sure_confidence() const override { return 0.3; }
  PatchPose estimate(const HandPatch& patch) const override {
    ++*asked_;
    return {std::vector<PatchPoint>(14, joint_), {patch.pixels(0, 0) == 1.0f ? 0.9f : 0.2f}};
  }

 private:
  PatchPoint joint_;
  int* asked_;
  PatchExtractor patches_;
};

TEST(SurestEstimator, WhereNothingIsSureThePatchIsTurned) {
  // The corner that the estimators know, and where a joint at (0.5, -0.25) of the turned patch lies in the
  // patch.
  struct Case {
    int u, v;
    double joint_u, joint_v;
    int views;  // that are needed
  };
  for (const Case& known : {Case{0, 0, 0.5, -0.25, 1}, Case{11, 11, -0.5, 0.25, 2},
                            Case{0, 11, -0.25, -0.5, 3}, Case{11, 0, 0.25, 0.5, 4}}) {
    for (int views = 1; views <= 4; ++views) {
      int asked = 0;
      std::vector<std::unique_ptr<Estimator>> estimators;
      for (int i = 0; i < 2; ++i)
        estimators.push_back(std::make_unique<KnowsOneWay>(PatchPoint{0.5, -0.25, 0.1}, &asked));
      const SurestEstimator surest(std::move(estimators), {.views = views});
      HandPatch patch{Image<float>(12, 12), {}, {}};
      patch.pixels(known.u, known.v) = 1.0f;
      const PatchPose pose = surest.estimate(patch);
      const bool is_found = views >= known.views;
      EXPECT_EQ(pose.confidence[0], is_found ? 0.9f : 0.2f) << known.views << ' ' << views;
      EXPECT_EQ(pose.joints[0].u, is_found ? known.joint_u : 0.5);
      EXPECT_EQ(pose.joints[0].v, is_found ? known.joint_v : -0.25);
      EXPECT_EQ(pose.joints[0].d, 0.1);
      const int turned = (is_found ? known.views : views) - 1;
      EXPECT_EQ(asked, is_found && known.views == 1 ? 1 : 2 + turned)
          << "the last alone; nobody once it is sure";
    }
  }
}

TEST(SurestEstimator, WhatIsSurelyNoHandIsNotTurned) {
  const auto looks = [](double right_hand) {
    int asked = 0;
    std::vector<std::unique_ptr<Estimator>> estimators;
    estimators.push_back(std::make_unique<KnownPose>(1.0, 0.4f, std::nullopt));
    estimators.push_back(std::make_unique<KnownPose>(2.0, 0.3f, right_hand, &asked));
    SurestEstimator(std::move(estimators), {.views = 4}).estimate({Image<float>(12, 12), {}, {}});
    return asked;
  };
  EXPECT_EQ(looks(0.08), 1);  // a hand with a likelihood of 0.04
  EXPECT_EQ(looks(0.12), 4);
}

/// Finds the brightest pixel of what it is shown and says that all joints are there; how sure it is, and of
/// which side, depends on the half of the image, upper or lower, in which that pixel lies.
class FindsBrightest final : public Estimator {
 public:
  struct Opinion {
    float confidence;
    double right_hand;
  };

  FindsBrightest(Opinion upper, Opinion lower)
      : upper_(upper), lower_(lower), patches_({.size_px = 13, .mode = "cube"}) {}

  Convention convention() const override { return convention_from_name("nyu14"); }
  const PatchExtractor& patches() const override { return patches_; }
  double sure_confidence() const override { return 0.3; }
  PatchPose estimate(const HandPatch& patch) const override {
    const Image<float>& image = patch.pixels;
    PatchPoint brightest;
    float most = -1.0f;
    for (int v = 0; v < image.height(); ++v) {
      for (int u = 0; u < image.width(); ++u) {
        if (image(u, v) <= most || image(u, v) == kCubeBackground) continue;
        most = image(u, v);
        brightest = {u / 6.0 - 1.0, v / 6.0 - 1.0, most};
      }
    }
    const Opinion& opinion = brightest.v < 0.0 ? upper_ : lower_;
    return {std::vector<PatchPoint>(14, brightest), std::vector<float>(14, opinion.confidence),
            opinion.right_hand};
  }

 private:
  Opinion upper_, lower_;
  PatchExtractor patches_;
};

/// A patch of 13 x 13 pixels, the brightest of which is this one.
HandPatch hill(int u, int v) {
  HandPatch patch{Image<float>(13, 13, kCubeBackground), {}, {}};
  for (int row = 0; row < 13; ++row) {
    for (int column = 0; column < 13; ++column)
      patch.pixels(column, row) = static_cast<float>(0.5 - 0.1 * std::hypot(column - u, row - v));
  }
  return patch;
}

/// Looks at a pixel of a patch through two of them; the second is the one that is sure.
PatchPose ascertained_pixel(int u, int v, double second_look_deg) {
  std::vector<std::unique_ptr<Estimator>> estimators;
  using Opinion = FindsBrightest::Opinion;
  estimators.push_back(std::make_unique<FindsBrightest>(Opinion{0.1f, 0.1}, Opinion{0.1f, 0.1}));
  estimators.push_back(std::make_unique<FindsBrightest>(Opinion{0.9f, 0.8}, Opinion{0.3f, 0.4}));
  const SurestEstimator surest(std::move(estimators), {.second_look_deg = second_look_deg});
  const HandPatch patch = hill(u, v);
  return surest.ascertained(patch, surest.estimate(patch));
}

TEST(SurestEstimator, AKeptPoseIsTheMeanOfTwoLooks) {
  // Up and to the right of the middle; a quarter turn takes it down and to the right.
  const PatchPose pose = ascertained_pixel(8, 1, 90.0);
  EXPECT_NEAR(pose.joints[0].u, 2.0 / 6.0, 1e-12) << "turned back, both looks see the same place";
  EXPECT_NEAR(pose.joints[0].v, -5.0 / 6.0, 1e-12);
  EXPECT_NEAR(pose.joints[0].d, 0.5, 1e-12);
  EXPECT_FLOAT_EQ(pose.confidence[0], 0.6f);
  EXPECT_EQ(pose.right_hand, 0.8) << "sided() asks for that";

  // By other angles places are rounded to pixels, which may take this one away: the brightest of a hill is
  // found.
  const PatchPose coarse = ascertained_pixel(8, 1, -40.0);
  EXPECT_NEAR(coarse.joints[3].u, 2.0 / 6.0, 0.5 / 6.0);
  EXPECT_NEAR(coarse.joints[3].v, -5.0 / 6.0, 0.5 / 6.0);
  EXPECT_NE(coarse.joints[3].u, 2.0 / 6.0) << "a mean";
}

/// Says 0.9, 0.6, 0.5 one after another of how likely a right hand is, and remembers where it saw the
/// brightest pixel of a patch.
class ChangesItsMind final : public Estimator {
 public:
  explicit ChangesItsMind(std::vector<double>* angles_deg) : angles_deg_(angles_deg) {}
  Convention convention() const override { return sees_.convention(); }
  const PatchExtractor& patches() const override { return sees_.patches(); }
  double sure_confidence() const override { return 0.3; }
  PatchPose estimate(const HandPatch& patch) const override {
    PatchPose pose = sees_.estimate(patch);
    angles_deg_->push_back(std::atan2(pose.joints[0].v, pose.joints[0].u) / kDegree);
    pose.right_hand = std::array{0.9, 0.6, 0.5}.at(angles_deg_->size() - 1);
    return pose;
  }

 private:
  FindsBrightest sees_{{0.5f, 0.0}, {0.5f, 0.0}};
  std::vector<double>* angles_deg_;
};

TEST(SurestEstimator, TheSideIsWhatTheLastSaysOfThreeLooks) {
  std::vector<double> angles_deg;
  std::vector<std::unique_ptr<Estimator>> estimators;
  using Opinion = FindsBrightest::Opinion;
  estimators.push_back(std::make_unique<FindsBrightest>(Opinion{0.7f, 0.2}, Opinion{0.7f, 0.2}));
  estimators.push_back(std::make_unique<ChangesItsMind>(&angles_deg));
  const SurestEstimator surest(std::move(estimators), {});
  PatchPose seen;
  seen.joints = {{0.25, 0.5, 0.0}};
  seen.right_hand = 0.2;
  seen.quarter_turns = 1;
  const PatchPose sided = surest.sided(hill(11, 6), seen);
  // Odds of 9, 3/2 and 1: their geometric mean is that of 27/2.
  const double odds = std::cbrt(13.5);
  EXPECT_NEAR(*sided.right_hand, odds / (1.0 + odds), 1e-9);
  EXPECT_EQ(sided.joints[0].u, 0.25) << "the pose stays";
  ASSERT_EQ(angles_deg.size(), 3u);
  EXPECT_NEAR(std::abs(angles_deg[0]), 90.0, 10.0) << "as the pose was seen: a quarter turned";
  EXPECT_NEAR(angles_deg[1] - angles_deg[0], -30.0, 12.0) << "places are whole pixels";
  EXPECT_NEAR(angles_deg[2] - angles_deg[0], 30.0, 12.0);
}

TEST(SurestEstimator, AClearSideNeedsNoOtherLook) {
  for (const double clear : {0.997, 0.003, 0.99}) {
    int asked = 0;
    std::vector<std::unique_ptr<Estimator>> estimators;
    estimators.push_back(std::make_unique<KnownPose>(1.0, 0.7f, 0.2));
    estimators.push_back(std::make_unique<KnownPose>(2.0, 0.7f, clear, &asked));
    const PatchPose sided = SurestEstimator(std::move(estimators), {}).sided(hill(6, 6), {});
    EXPECT_NEAR(*sided.right_hand, clear, 1e-9);
    EXPECT_EQ(asked, clear == 0.99 ? 3 : 1);
  }
}

TEST(SurestEstimator, TheSideStaysWhereTheLastCannotTellIt) {
  std::vector<std::unique_ptr<Estimator>> estimators;
  estimators.push_back(std::make_unique<KnownPose>(1.0, 0.7f, 0.2));
  estimators.push_back(std::make_unique<KnownPose>(2.0, 0.7f, std::nullopt));
  PatchPose seen;
  seen.right_hand = 0.2;
  EXPECT_EQ(SurestEstimator(std::move(estimators), {}).sided(hill(6, 6), seen).right_hand, 0.2);
}

TEST(SurestEstimator, WithoutASecondLookAPoseStaysAsItIs) {
  const PatchPose pose = ascertained_pixel(8, 1, 0.0);
  EXPECT_EQ(pose.joints[0].u, 8 / 6.0 - 1.0);
  EXPECT_EQ(pose.confidence[0], 0.9f);
  EXPECT_EQ(pose.right_hand, 0.8);
}

TEST(SurestEstimator, TheSecondLookIsTurnedAgainstTheFirst) {
  // Upside down the pixel is in the upper half, where the last one is sure.
  std::vector<std::unique_ptr<Estimator>> estimators;
  using Opinion = FindsBrightest::Opinion;
  for (int i = 0; i < 2; ++i)
    estimators.push_back(std::make_unique<FindsBrightest>(Opinion{0.9f, 0.8}, Opinion{0.3f, 0.4}));
  const SurestEstimator surest(std::move(estimators), {.views = 2, .second_look_deg = 90.0});
  HandPatch patch{Image<float>(13, 13, kCubeBackground), {}, {}};
  patch.pixels(2, 10) = 0.5f;
  const PatchPose first = surest.estimate(patch);
  EXPECT_EQ(first.confidence[0], 0.9f);
  EXPECT_EQ(first.quarter_turns, 2);
  EXPECT_EQ(first.seen_by, 1);
  // Turned by three quarters it is in the lower half, where that is less sure; by one quarter it would not
  // be.
  const PatchPose pose = surest.ascertained(patch, first);
  EXPECT_FLOAT_EQ(pose.confidence[0], 0.6f);
  EXPECT_NEAR(pose.joints[0].u, -4.0 / 6.0, 1e-12);
  EXPECT_NEAR(pose.joints[0].v, 4.0 / 6.0, 1e-12);
}

TEST(SurestEstimator, WhatDoesNotBelongTogetherIsRefused) {
  const auto fault = [](std::unique_ptr<Estimator> other) {
    std::vector<std::unique_ptr<Estimator>> estimators;
    estimators.push_back(std::make_unique<KnownPose>(1.0, 0.5f, std::nullopt));
    if (other) estimators.push_back(std::move(other));
    return error_of([&] { SurestEstimator(std::move(estimators), {}); });
  };
  EXPECT_THAT(fault(nullptr), HasSubstr("1 given, expected two or more"));
  EXPECT_THAT(fault(std::make_unique<KnownPose>(1.0, 0.5f, std::nullopt, nullptr, "icvl16")),
              HasSubstr("one predicts \"nyu14\", another one \"icvl16\""));
  EXPECT_THAT(fault(std::make_unique<KnownPose>(1.0, 0.5f, std::nullopt, nullptr, "nyu14", 16)),
              HasSubstr("patches of different kinds"));
  EXPECT_THAT(fault(std::make_unique<KnownPose>(1.0, -1.0f, std::nullopt)), HasSubstr("confidences of one"));
}

TEST(SurestEstimator, IsMadeFromAFile) {
  const testing::TemporaryFolder folder;
  NetworkOptions network = testing::small_network();
  network.architecture = "dense";
  for (const char* name : {"a.pt", "b.pt"}) save_network_weights(folder / name, random_weights(network, 1));
  const auto create = [&](const std::string& toml) {
    write_text_file(folder / "p.toml", "method = \"surest\"\n" + toml);
    return create_estimator(OptionTable::load(folder / "p.toml"));
  };
  EXPECT_EQ(create("models = [\"a.pt\", \"b.pt\"]\npasses = 3")->passes(), 3);
  const auto fault = [&](const std::string& toml) { return error_of([&] { create(toml); }); };
  EXPECT_THAT(fault("models = [\"a.pt\"]"),
              ::testing::AllOf(HasSubstr("p.toml:2"), HasSubstr("two or more")));
  EXPECT_THAT(fault(""), ::testing::AllOf(HasSubstr("p.toml"), HasSubstr("models")));
  EXPECT_THAT(fault("models = [\"a.pt\", \"none.pt\"]"), HasSubstr("none.pt"));
  EXPECT_THAT(fault("models = [\"a.pt\", \"b.pt\"]\nlead = 2"), HasSubstr("lead"));
  EXPECT_THAT(fault("models = [\"a.pt\", \"b.pt\"]\nviews = 5"), HasSubstr("views"));
  EXPECT_THAT(
      fault("models = [\"a.pt\", \"b.pt\"]\njudge = \"a.pt\""),
      ::testing::AllOf(HasSubstr("p.toml:3"), HasSubstr("a.pt does not tell whether there is a hand")));
  EXPECT_THAT(fault("models = [\"a.pt\", \"b.pt\"]\njudge = \"none.pt\""), HasSubstr("none.pt"));
  network.dense.tells_hand = true;
  save_network_weights(folder / "judge.pt", random_weights(network, 1));
  const auto judging = create("models = [\"a.pt\", \"b.pt\"]\njudge = \"judge.pt\"");
  const int size_px = network.patch.size_px;
  EXPECT_TRUE(judging->judged({Image<float>(size_px, size_px, 0.0f), {}, {}}, {}).hand);
  EXPECT_THAT(fault("models = [\"a.pt\", \"b.pt\"]\nsecond_look_deg = 91"), HasSubstr("second_look_deg"));
  EXPECT_THAT(fault("models = [\"a.pt\", \"b.pt\"]\nmodel = \"a.pt\""), HasSubstr("model"));
}

}  // namespace
}  // namespace knuckle
