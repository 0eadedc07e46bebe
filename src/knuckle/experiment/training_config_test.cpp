// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/training_config.h"

#include "knuckle/core/resources.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/experiment/network_config.h"
#include "knuckle/prepare/pose_forest_training.h"
#include "knuckle/prepare/segmentation_forest_training.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/synth/manifest.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

class TrainingConfigTest : public ::testing::Test {
 protected:
  /// A shipped configuration at scale `s`, read again.
  template <class Config>
  Config scaled(const std::string& kind, const std::string& original, double s) {
    training_ = write_scaled_training(kind, resource_path(original), s, folder_ / "model.toml");
    return Config::load(training_.config);
  }

  TemporaryFolder folder_;
  ScaledTraining training_;
};

TEST_F(TrainingConfigTest, TheWholeAsksForTheSame) {
  const auto original = NetworkConfig::load(resource_path("pipelines/train_pca.toml"));
  const auto config = scaled<NetworkConfig>("network", "pipelines/train_pca.toml", 1.0);
  EXPECT_EQ(network_options_as_toml(config.network), network_options_as_toml(original.network));
  EXPECT_THAT(read_text_file(training_.config), HasSubstr("epochs = 2.125"));
  EXPECT_TRUE(std::filesystem::equivalent(parse_source_spec(config.source).path,
                                          parse_source_spec(original.source).path));
}

TEST_F(TrainingConfigTest, ANetworkBecomesSmall) {
  const auto config = scaled<NetworkConfig>("network", "pipelines/train_regression.toml", 0.01);
  const std::string text = read_text_file(training_.config);
  EXPECT_THAT(text, HasSubstr("most = 2000"));
  EXPECT_THAT(text, HasSubstr("epochs = 1.0\n"));
  EXPECT_EQ(config.network.paper.hidden_units, 410);
  EXPECT_EQ(config.network.paper.subspace_units, 20) << "what is learned stays the same";
  EXPECT_EQ(config.network.patch.size_px, 96);
  ASSERT_EQ(training_.sources.size(), 2u);
  const SourceSpec frames = parse_source_spec(config.source);
  EXPECT_EQ(frames.selection.count, 2000);
  EXPECT_EQ(load_manifest(frames.path).body.people, 60);
  EXPECT_EQ(parse_source_spec(config.validation).selection.count, 20);
}

TEST_F(TrainingConfigTest, ForestsBecomeSmall) {
  const auto pose =
      scaled<PoseForestTrainingConfig>("pose-forest", "experiments/scia15/train_pose_forest.toml", 0.01);
  EXPECT_EQ(pose.forest.forest.trees, 2);
  EXPECT_EQ(pose.forest.forest.tree.max_depth, 18);  // 25 - log2(100)
  EXPECT_EQ(pose.forest.forest.tree.splits_per_node, 1000);
  EXPECT_EQ(parse_source_spec(pose.source).selection.count, 4000);
  const auto pixels = scaled<SegmentationForestTrainingConfig>(
      "segmentation-forest", "pipelines/train_segmentation_forest.toml", 0.01);
  EXPECT_EQ(pixels.forest.trees, 2);
  EXPECT_EQ(parse_source_spec(pixels.source).selection.count, 4000);
}

TEST_F(TrainingConfigTest, AScaledManifestShowsTheSameFramesOfFewerPeople) {
  const auto config = scaled<NetworkConfig>("network", "pipelines/train_dense.toml", 0.01);
  const Manifest small = load_manifest(parse_source_spec(config.source).path);
  const Manifest whole = load_manifest(resource_path("manifests/train_network.toml"));
  EXPECT_EQ(small.seed, whole.seed);
  EXPECT_EQ(options_as_toml(small.pose), options_as_toml(whole.pose));
  EXPECT_EQ(options_as_toml(small.sensor), options_as_toml(whole.sensor));
  EXPECT_EQ(options_as_toml(small.camera), options_as_toml(whole.camera));
}

TEST_F(TrainingConfigTest, AFileThatStaysTheSameIsLeftAlone) {
  scaled<NetworkConfig>("network", "pipelines/train_dense.toml", 0.1);
  const auto time = std::filesystem::last_write_time(folder_ / "model.toml");
  scaled<NetworkConfig>("network", "pipelines/train_dense.toml", 0.1);
  EXPECT_EQ(std::filesystem::last_write_time(folder_ / "model.toml"), time);
  scaled<NetworkConfig>("network", "pipelines/train_dense.toml", 0.2);
  EXPECT_NE(std::filesystem::last_write_time(folder_ / "model.toml"), time);
}

TEST_F(TrainingConfigTest, AFaultIsNamedWhereItIsWritten) {
  write_text_file(folder_ / "wrong.toml", "source = \"synthetic:scene.toml\"\n[forest]\ntrees = 0\n");
  EXPECT_THAT(error_of([&] {
                write_scaled_training("pose-forest", folder_ / "wrong.toml", 0.1, folder_ / "model.toml");
              }),
              HasSubstr("wrong.toml:3: forest.trees"));
}

}  // namespace
}  // namespace knuckle::testing
