// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/pose_forest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "knuckle/core/testing.h"
#include "knuckle/estimate/estimate_testing.h"
#include "knuckle/prepare/train_pose_forest.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::change_model;
using testing::error_of;
using ::testing::HasSubstr;
using testing::kTestPatchSize;
using testing::made_up_hand;
using testing::made_up_model;
using testing::TemporaryFolder;

const Convention& convention() {
  return convention_from_name("nyu14");
}

TEST(TrainPoseForest, RemembersItsSamplesAndLearnsTheSlants) {
  const PoseForestEstimator estimator(made_up_model(convention()));
  EXPECT_EQ(estimator.convention(), convention());
  for (std::uint64_t i = 0; i < 20; ++i) {
    const auto [patch, joints] = made_up_hand(i, convention());
    const PatchPose pose = estimator.estimate(patch);
    ASSERT_EQ(pose.joints.size(), joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j) {
      EXPECT_NEAR(pose.joints[j].u, joints[j].u, 1e-3);
      EXPECT_NEAR(pose.joints[j].v, joints[j].v, 1e-3);
      EXPECT_NEAR(pose.joints[j].d, joints[j].d, 1e-3);
      EXPECT_GT(pose.confidence[j], 0.99F);
    }
  }
  double error = 0.0;
  for (std::uint64_t i = 100000; i < 100100; ++i) {
    const auto [unseen, truth] = made_up_hand(i, convention());
    const PatchPose pose = estimator.estimate(unseen);
    error += std::abs(pose.joints[3].u - truth[3].u) / 100.0;
    EXPECT_LE(pose.confidence[3], 1.0F);
  }
  EXPECT_LT(error, 0.1);  // a constant answer has 0.5
}

TEST(TrainPoseForest, LeavesOutSamplesWithAMissingJoint) {
  PoseTrainingSet set(3, convention(), {.size_px = kTestPatchSize, .mean = {}, .whitening = {}});
  auto [patch, joints] = made_up_hand(1, convention());
  EXPECT_EQ(set.set(0, patch, joints), PoseTrainingSet::Kept::yes);
  joints[5] = PatchPoint{};
  EXPECT_EQ(set.set(1, patch, joints), PoseTrainingSet::Kept::joint_missing);
  EXPECT_EQ(set.kept_count(), 1);
}

TEST(TrainPoseForest, RefusesWhatDoesNotFit) {
  PoseTrainingSet set(3, convention(), {.size_px = kTestPatchSize, .mean = {}, .whitening = {}});
  HandPatch patch = made_up_hand(1, convention()).first;
  const std::vector<PatchPoint> joints = made_up_hand(1, convention()).second;
  EXPECT_THAT(error_of([&] { train_pose_forest(set, {}); }), HasSubstr("no samples"));
  EXPECT_THAT(error_of([&] { check_training_memory(10000000, convention(), 96, {}); }),
              HasSubstr("memory_gb"));
  EXPECT_THAT(error_of([&] { set.set(2, patch, std::span(joints).first(3)); }),
              HasSubstr("expected the 14 of nyu14"));
  patch.pixels(3, 3) = std::nanf("");
  EXPECT_THAT(error_of([&] { set.set(2, patch, joints); }), AllOf(HasSubstr("sample 2"), HasSubstr("nan")));
  patch.pixels = Image<float>(5, 5);
  EXPECT_THAT(error_of([&] { set.set(2, patch, joints); }), HasSubstr("expected 12 x 12"));
}

TEST(PoseForestEstimator, RefusesPatchesOfAnotherSizeOrNotFinite) {
  const PoseForestEstimator estimator(made_up_model(convention()));
  HandPatch patch = made_up_hand(1, convention()).first;
  patch.pixels(0, 5) = INFINITY;
  EXPECT_THAT(error_of([&] { estimator.estimate(patch); }), HasSubstr("not finite"));
  patch.pixels = Image<float>(96, 96);
  EXPECT_THAT(error_of([&] { estimator.estimate(patch); }), HasSubstr("96 x 96, expected 12 x 12"));
}

constexpr std::size_t kTargets = 3 * 14;  // of nyu14

/// A forest on patches of 2 x 2 whose leaves differ in the fourth landmark alone: in each its u, v and d.
PoseForestModel forest_of(FlatTrees<PixelPair> trees, const std::vector<std::array<float, 3>>& leaves) {
  std::vector<float> values(leaves.size() * kTargets, 0.0F);
  for (std::size_t i = 0; i < leaves.size(); ++i)
    std::ranges::copy(leaves[i], values.begin() + i * kTargets + 9);
  RegressionForest::Parts parts;
  parts.feature_count = 4;
  parts.trees = std::move(trees);
  parts.leaves = LeafTable(kTargets, values, 32);
  return {
      convention(), {.size_px = 2, .mean = {}, .whitening = {}}, RegressionForest(std::move(parts), "test")};
}

HandPatch patch_of(const std::array<float, 4>& pixels) {
  HandPatch patch;
  patch.pixels = Image<float>(2, 2);
  std::ranges::copy(pixels, patch.pixels.data());
  return patch;
}

TEST(PoseForestEstimator, ConfidenceIsTheAgreementInUAndV) {
  const FlatTrees<PixelPair> two_leaves{{0, 1}, {{~0, {}, 0}, {~1, {}, 0}}};
  const auto confidence = [&](const std::array<float, 3>& one, const std::array<float, 3>& other) {
    return PoseForestEstimator(forest_of(two_leaves, {one, other})).estimate(patch_of({})).confidence[3];
  };
  // Deviations of 0.1 along an axis are a root mean square of 0.1 / sqrt(2): exp(-0.707).
  EXPECT_NEAR(confidence({0.1F, 0.0F, 0.0F}, {-0.1F, 0.0F, 0.0F}), 0.4931F, 1e-4F);
  EXPECT_NEAR(confidence({0.3F, 0.1F, 0.0F}, {0.3F, -0.1F, 0.0F}), 0.4931F, 1e-4F);
  EXPECT_NEAR(confidence({0.1F, 0.1F, 0.0F}, {-0.1F, -0.1F, 0.0F}), 0.3679F, 1e-4F);
  EXPECT_NEAR(confidence({0.2F, 0.0F, 3.0F}, {0.2F, 0.0F, -3.0F}), 1.0F, 1e-6F);  // whatever the depth
}

TEST(PoseForestEstimator, ASingleTreeGivesNoConfidence) {
  const PoseForestEstimator estimator(forest_of({{0}, {{~0, {}, 0}}}, {{0.1F, 0.2F, 0.3F}}));
  const PatchPose pose = estimator.estimate(patch_of({}));
  EXPECT_NEAR(pose.joints[3].v, 0.2, 1e-6);
  EXPECT_TRUE(pose.confidence.empty());
  EXPECT_EQ(estimator.sure_confidence(), 0.0);
}

TEST(PoseForestModel, InPruningDepthCountsAQuarter) {
  const FlatTrees<PixelPair> tree{
      {0},
      {{1, {0, 1}, 0}, {3, {2, 3}, 0}, {5, {2, 3}, 0}, {~0, {}, 0}, {~1, {}, 0}, {~2, {}, 0}, {~3, {}, 0}}};
  // On the left leaves that differ by 0.5 in v, on the right ones that differ by 1 in d.
  const PoseForestModel model =
      forest_of(tree, {{0.0F, -0.25F, 0.0F}, {0.0F, 0.25F, 0.0F}, {0.0F, 0.0F, -0.5F}, {0.0F, 0.0F, 0.5F}});
  const PoseForestEstimator estimator(pruned(model, 3));
  EXPECT_NEAR(estimator.estimate(patch_of({0.0F, 1.0F, 0.0F, 1.0F})).joints[3].v, -0.25, 1e-6);
  EXPECT_NEAR(estimator.estimate(patch_of({0.0F, 1.0F, 1.0F, 0.0F})).joints[3].v, 0.25, 1e-6);
  EXPECT_NEAR(estimator.estimate(patch_of({1.0F, 0.0F, 0.0F, 1.0F})).joints[3].d, 0.0, 1e-6);
  EXPECT_NEAR(estimator.estimate(patch_of({1.0F, 0.0F, 1.0F, 0.0F})).joints[3].d, 0.0, 1e-6);
}

TEST(PoseForestModel, SavedAndLoadedAnswersTheSame) {
  const TemporaryFolder folder;
  PoseForestModel model = made_up_model(convention());
  model.statistics.mean = Image<float>(kTestPatchSize, kTestPatchSize, 0.25F);
  save_pose_forest(folder / "m.model", model);
  const PoseForestEstimator before(model);
  const PoseForestEstimator after(load_pose_forest(folder / "m.model"));
  EXPECT_EQ(after.convention(), convention());
  EXPECT_EQ(after.patches().statistics().mean, model.statistics.mean);
  for (std::uint64_t i = 5000; i < 5050; ++i) {
    const HandPatch patch = made_up_hand(i, convention()).first;
    const PatchPose a = before.estimate(patch);
    const PatchPose b = after.estimate(patch);
    for (std::size_t j = 0; j < a.joints.size(); ++j) {
      ASSERT_EQ(a.joints[j].u, b.joints[j].u);
      ASSERT_EQ(a.joints[j].v, b.joints[j].v);
      ASSERT_EQ(a.joints[j].d, b.joints[j].d);
    }
    ASSERT_EQ(a.confidence, b.confidence);
  }
}

/// A sound model file of which the test spoils one thing.
class PoseForestFile : public ::testing::Test {
 protected:
  PoseForestFile() { save_pose_forest(path_, made_up_model(convention())); }

  std::string fault() const {
    return error_of([this] { load_pose_forest(path_); });
  }

  /// Sets the first value of an array.
  template <class T>
  void change_value(const std::string& array, T value) const {
    ModelArray<T> changed = ModelFile::open(path_).read<T>(array);
    changed.values[0] = value;
    change_model(path_, [&](ModelWriter& model) { model.add(array, changed.shape, changed.values); });
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "forest.model";
};

TEST_F(PoseForestFile, OfAnotherVersionIsRefused) {
  change_model(path_, [](ModelWriter& model) { model.set_format("knuckle-forest", 3); });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("version")));
}

TEST_F(PoseForestFile, OfAnotherKindOrFormatIsRefused) {
  change_model(path_, [](ModelWriter& model) { model.set("kind", "segmentation"); });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("segmentation")));
  change_model(path_, [](ModelWriter& model) { model.set_format("knuckle-body", 2); });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("knuckle-body")));
}

TEST_F(PoseForestFile, CutShortForeignOrMissingIsRefused) {
  const auto size = std::filesystem::file_size(path_);
  for (const double part : {0.99, 0.5, 0.02}) {
    std::filesystem::resize_file(path_, static_cast<std::uintmax_t>(part * static_cast<double>(size)));
    EXPECT_THAT(fault(), HasSubstr("forest.model")) << part;
  }
  write_text_file(path_, "this is not a forest");
  EXPECT_THAT(fault(), HasSubstr("forest.model"));
  std::filesystem::remove(path_);
  EXPECT_THAT(fault(), HasSubstr("forest.model"));
}

TEST_F(PoseForestFile, OfAnUnknownConventionOrPatchSizeIsRefused) {
  change_model(path_, [](ModelWriter& model) { model.set("patch_size_px", 96.0); });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("96 x 96")));
  change_model(path_, [](ModelWriter& model) {
    model.set("patch_size_px", double{kTestPatchSize});
    model.set("convention", "octopus8");
  });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("octopus8")));
  change_model(path_, [](ModelWriter& model) { model.set("convention", "icvl16"); });
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("16 landmarks of icvl16")));
}

TEST_F(PoseForestFile, WithAMeanPatchOfAnotherSizeIsRefused) {
  change_model(path_, [](ModelWriter& model) { model.add("patch_mean", {3, 48}, std::vector<float>(144)); });
  EXPECT_THAT(fault(),
              AllOf(HasSubstr("forest.model"), HasSubstr("patch_mean has 144 values, expected 12 x 12")));
  PoseForestModel wrong = made_up_model(convention());
  wrong.statistics.mean = Image<float>(kTestPatchSize, 5);
  EXPECT_THAT(error_of([&] { PoseForestEstimator{wrong}; }),
              HasSubstr("the mean patch is 12 x 5, expected 12 x 12"));
}

TEST_F(PoseForestFile, WithANumberThatIsNotFiniteIsRefused) {
  std::vector<float> mean(144);
  mean[7] = std::nanf("");
  change_model(path_, [&](ModelWriter& model) { model.add("patch_mean", {12, 12}, mean); });
  EXPECT_THAT(fault(),
              AllOf(HasSubstr("forest.model"), HasSubstr("a pixel of the mean patch is not finite")));
  save_pose_forest(path_, made_up_model(convention()));
  change_value("leaf_offset", std::nanf(""));
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("a leaf offset or step is not finite")));
}

TEST_F(PoseForestFile, WithAChildOrAFeatureOutOfRangeIsRefused) {
  change_value<std::uint16_t>("node_first", 65535);
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("reads a feature beyond")));
  save_pose_forest(path_, made_up_model(convention()));
  change_value<std::uint8_t>("node_is_leaf", 1);
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("leads nowhere")));
  save_pose_forest(path_, made_up_model(convention()));
  change_value<std::uint32_t>("tree_root", 7);
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("no first tree")));
}

TEST_F(PoseForestFile, WhoseLeavesOverflowIsRefused) {
  change_value("leaf_step", 3e38F);
  EXPECT_THAT(fault(), AllOf(HasSubstr("forest.model"), HasSubstr("a leaf value is not finite")));
}

TEST_F(PoseForestFile, ThatCannotBeWrittenLeavesNothing) {
  const std::filesystem::path nowhere = folder_ / "no_such_folder" / "forest.model";
  EXPECT_THAT(error_of([&] { save_pose_forest(nowhere, made_up_model(convention())); }),
              HasSubstr("no_such_folder"));
  PoseForestModel wrong = made_up_model(convention());
  wrong.statistics.whitening = {1.0F};
  EXPECT_THAT(error_of([&] { save_pose_forest(folder_ / "w.model", wrong); }), HasSubstr("no whitening"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "w.model"));
}

}  // namespace
}  // namespace knuckle
