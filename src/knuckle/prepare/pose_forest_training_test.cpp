// SPDX-License-Identifier: Apache-2.0
#include "knuckle/prepare/pose_forest_training.h"

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"
#include "knuckle/data/writers/folder_writer.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

constexpr int kFrames = 30;

/// A slanted plate whose palm and index tip follow from the slant; nothing of it is symmetric.
Frame slanted_frame(int i) {
  Random random(3, static_cast<std::uint64_t>(i));
  Frame frame;
  frame.camera = {.width = 80, .height = 60, .fx = 100.0, .fy = 100.0, .cx = 39.5, .cy = 29.5};
  frame.depth_mm = Image<float>(80, 60);
  const double slant = random.uniform(-1.0, 1.0);
  for (int row = 20; row < 40; ++row) {
    for (int column = 10; column < 34; ++column)
      frame.depth_mm(column, row) = static_cast<float>(500.0 + slant * (column - 22));
  }
  frame.truth = HandPose::missing(superset_convention());
  for (std::size_t j = 0; j < frame.truth->joints.size(); ++j)
    frame.truth->joints[j] = {20.0 + slant * static_cast<double>(j % 5), 25.0 + static_cast<double>(j % 7),
                              505.0};
  return frame;
}

class PoseForestTrainingTest : public ::testing::Test {
 protected:
  void write_set(const std::string& name, const std::function<void(int, Frame&)>& change = {}) const {
    FrameWriterOptions options;
    options.count = kFrames;
    FolderWriter writer(folder_ / name, options);
    for (int i = 0; i < kFrames; ++i) {
      Frame frame = slanted_frame(i);
      if (change) change(i, frame);
      writer.write(i, frame);
    }
    writer.finish();
  }

  PoseForestTraining train(const std::string& set, const std::string& more = "") const {
    write_text_file(folder_ / "c.toml",
                    "source = 'folder:" + set + "'\nconvention = 'icg20'\nstart = 'nearest'\n" + more +
                        "[segmentation]\nmethod = 'threshold'\nmin_area_mm2 = 0\n"
                        "[patch]\nsize_px = 16\n"
                        "[forest]\ntrees = 2\nsplits_per_node = 200\nmin_leaf_samples = 1\n");
    return run_training(PoseForestTrainingConfig::load(folder_ / "c.toml"), {});
  }

  testing::TemporaryFolder folder_;
};

TEST_F(PoseForestTrainingTest, ALeftHandsForestIsThatOfTheMirroredFrames) {
  write_set("right");
  write_set("left", [](int, Frame& frame) { frame = mirrored(frame); });
  const PoseForestTraining right = train("right");
  const PoseForestTraining left = train("left", "[hand]\nside = 'left'\n");
  EXPECT_EQ(right.frames.used(), kFrames);
  const PoseForestEstimator a(right.model);
  const PoseForestEstimator b(left.model);
  const PatchExtractor extractor({.size_px = 16});
  for (int i = 100; i < 105; ++i) {
    HandRegion region;
    region.box = {10, 20, 24, 20};
    region.mask = Image<std::uint8_t>(24, 20, 1);
    const HandPatch patch = *extractor.extract(slanted_frame(i), region);
    for (std::size_t j = 0; j < 20; ++j) {
      EXPECT_NEAR(a.estimate(patch).joints[j].u, b.estimate(patch).joints[j].u, 1e-3);
      EXPECT_NEAR(a.estimate(patch).joints[j].v, b.estimate(patch).joints[j].v, 1e-3);
    }
  }
}

TEST_F(PoseForestTrainingTest, CountsWhatBecameOfTheFrames) {
  write_set("set", [](int i, Frame& frame) {
    if (i < 3) std::ranges::fill(frame.depth_mm.pixels(), 0.0f);
    if (i == 5 || i == 6) frame.truth->joints[static_cast<std::size_t>(Landmark::ring_dip)] = {};
    if (i == 8) frame.truth->joints[static_cast<std::size_t>(Landmark::wrist)] = {};  // icg20 has none
  });
  const TrainingFrames frames = train("set").frames;
  EXPECT_EQ(frames.total, kFrames);
  EXPECT_EQ(frames.without_hand, 3);
  EXPECT_EQ(frames.with_missing_joints, 2);
}

/// A set in which v follows one slant of the patch and d the other.
TEST_F(PoseForestTrainingTest, WithoutTruthOrAHandThereIsNothingToTrainOn) {
  write_set("plain", [](int, Frame& frame) { frame.truth.reset(); });
  EXPECT_THAT(testing::error_of([&] { train("plain"); }),
              ::testing::AllOf(::testing::HasSubstr("plain"), ::testing::HasSubstr("no truth to train on")));
  write_set("unknown", [](int, Frame& frame) { frame.truth = HandPose::missing(superset_convention()); });
  EXPECT_THAT(
      testing::error_of([&] { train("unknown"); }),
      ::testing::AllOf(::testing::HasSubstr("unknown"), ::testing::HasSubstr("no frame can be trained on")));
}

TEST(TrainPoseForestWeights, WithoutWeightOnDepthSplitsFollowUAndVAlone) {
  const Convention& convention = convention_from_name("nyu14");
  constexpr int kSize = 12;
  const auto sample = [&](std::uint64_t id) {
    Random random(5, id);
    const double slant_u = random.uniform(-1.0, 1.0);
    const double slant_v = random.uniform(-1.0, 1.0);
    HandPatch patch;
    patch.pixels = Image<float>(kSize, kSize);
    for (int v = 0; v < kSize; ++v) {
      for (int u = 0; u < kSize; ++u)
        patch.pixels(u, v) = static_cast<float>((slant_u * u + slant_v * v) / kSize);
    }
    return std::pair(patch, std::vector<PatchPoint>(14, {0.0, slant_v, slant_u}));
  };
  PoseTrainingSet set(600, convention, {.size_px = kSize, .mean = {}, .whitening = {}});
  for (std::uint64_t i = 0; i < 600; ++i)
    set.set(static_cast<std::int64_t>(i), sample(i).first, sample(i).second);
  PoseForestTrainingOptions options;
  options.forest.trees = 4;
  options.forest.tree.max_depth = 4;
  options.forest.tree.splits_per_node = 300;
  options.depth_weight = 0.0;
  const PoseForestEstimator estimator(train_pose_forest(set, options));
  double error_v = 0.0;
  double error_d = 0.0;
  for (std::uint64_t i = 10000; i < 10200; ++i) {
    const auto [patch, truth] = sample(i);
    const PatchPose pose = estimator.estimate(patch);
    error_v += std::abs(pose.joints[3].v - truth[3].v) / 200.0;
    error_d += std::abs(pose.joints[3].d - truth[3].d) / 200.0;
  }
  EXPECT_LT(error_v, 0.15);  // a constant answer has 0.5
  EXPECT_GT(error_d, 0.4);
}

TEST(PoseForest, TakesSamplesOfItsOwnSizesAlone) {
  PoseTrainingSet set(1, convention_from_name("nyu14"), {.size_px = 8, .mean = {}, .whitening = {}});
  HandPatch patch;
  patch.pixels = Image<float>(8, 7);
  const std::vector<PatchPoint> joints(14);
  EXPECT_THAT(error_of([&] { set.set(0, patch, joints); }), HasSubstr("a patch of 8 x 7, expected 8 x 8"));
  patch.pixels = Image<float>(7, 8);
  EXPECT_THAT(error_of([&] { set.set(0, patch, joints); }), HasSubstr("a patch of 7 x 8, expected 8 x 8"));
  patch.pixels = Image<float>(8, 8);
  EXPECT_THAT(error_of([&] { set.set(0, patch, std::vector<PatchPoint>(13)); }),
              HasSubstr("13 joints, expected the 14 of nyu14"));
}

}  // namespace
}  // namespace knuckle
