// SPDX-License-Identifier: Apache-2.0
// The paper's five networks.
#include <torch/utils.h>

#include "knuckle/core/testing.h"
#include "knuckle/net/heat_map_decoding.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/training/heat_map_network.h"
#include "knuckle/training/loss_gradient_testing.h"
#include "knuckle/training/network_training.h"
#include "knuckle/training/regression_network.h"
#include "knuckle/training/training_testing.h"

namespace knuckle {
namespace {

using testing::kTestJoints;
using testing::TemporaryFolder;

NetworkOptions paper_options(const std::string& architecture) {
  NetworkOptions options;
  options.architecture = architecture;
  options.convention = "icg20";
  options.paper.hidden_units = 64;  // of 4096: the paper's size is 49 million weights
  return options;
}

NetworkOptions small_options(const std::string& architecture) {
  NetworkOptions options = testing::small_network();
  options.architecture = architecture;
  return options;
}

int64_t parameter_count(const torch::nn::Module& module) {
  int64_t count = 0;
  for (const torch::Tensor& parameter : module.parameters()) count += parameter.numel();
  return count;
}

constexpr int64_t kBanks = 416 + 18464 + 416 + 12832 + 272 + 8224;

/// Numbers of fully connected layers of these widths: a scale and a shift for each of the hidden units,
/// a bias for each of the linear ones after them.
int64_t connected(int64_t inputs, std::initializer_list<int64_t> hidden,
                  std::initializer_list<int64_t> linear) {
  int64_t count = 0;
  for (const int64_t units : hidden) {
    count += (inputs + 2) * units;
    inputs = units;
  }
  for (const int64_t units : linear) {
    count += (inputs + 1) * units;
    inputs = units;
  }
  return count;
}

TEST(ConvolutionBanks, EndIn32MapsOf9x9Each) {
  ConvolutionBanks banks(96, 16, 32);
  EXPECT_EQ(banks.feature_count(), 7776);
  EXPECT_EQ(parameter_count(banks), kBanks);
  const torch::NoGradGuard no_gradient;
  EXPECT_EQ(banks.forward(torch::rand({2, 1, 96, 96})).sizes(), torch::IntArrayRef({2, 7776}));
  ConvolutionBanks smallest(32, 2, 3);
  EXPECT_EQ(smallest.forward(torch::rand({1, 1, 32, 32})).size(1), smallest.feature_count());
}

struct Expected {
  std::string architecture;
  int64_t outputs;
  int64_t parameters;
};

class PaperNetworks : public ::testing::TestWithParam<Expected> {};

INSTANTIATE_TEST_SUITE_P(
    , PaperNetworks,
    ::testing::Values(Expected{"heatmap2d", 20 * 324, connected(7776, {64}, {20 * 324})},
                      Expected{"heatmap25d", 20 * 349, connected(7776, {64}, {20 * 349})},
                      Expected{"regression", 60, connected(7776, {64, 64}, {60})},
                      Expected{"pca", 60, connected(7776, {64, 64}, {20, 60})},
                      Expected{"autoencoder", 60, connected(7776, {64, 64, 20, 64}, {60})}),
    [](const auto& instance) { return instance.param.architecture; });

TEST(PaperNetworkOptions, AreThePapers) {
  const PaperNetworkOptions options;
  EXPECT_EQ(options.hidden_units, 4096);
  EXPECT_EQ(options.subspace_units, 20);
  EXPECT_EQ(options.dropout, 0.5);
  EXPECT_EQ(options.map_cells, 18);
  EXPECT_EQ(options.depth_bins, 25);
}

TEST_P(PaperNetworks, HaveThePapersLayers) {
  const auto network = make_network(paper_options(GetParam().architecture), 1);
  EXPECT_EQ(parameter_count(*network), kBanks + GetParam().parameters);
  network->eval();
  const torch::NoGradGuard no_gradient;
  const torch::Tensor patches = torch::rand({1, 1, 96, 96}) - 0.5;
  const torch::Tensor output = network->forward(patches);
  EXPECT_EQ(output.sizes(), torch::IntArrayRef({1, GetParam().outputs}));
  EXPECT_EQ(network->decode(output, patches).joints.sizes(), torch::IntArrayRef({1, 20, 3}));
}

TEST_P(PaperNetworks, TheLossHasTheGradientOfFiniteDifferences) {
  const auto network = make_network(small_options(GetParam().architecture), 1);
  torch::manual_seed(4);
  const torch::Tensor patches = torch::rand({2, 1, 32, 32}, torch::kDouble);
  torch::Tensor joints = 1.6 * torch::rand({2, kTestJoints, 3}, torch::kDouble) - 0.8;
  joints[1][2][0] = kNaN;
  const int64_t width = network->forward(patches.to(torch::kFloat)).size(1);
  testing::expect_gradient_of_finite_differences(*network, patches, joints,
                                                 torch::randn({2, width}, torch::kDouble));
}

TEST_P(PaperNetworks, DropoutDependsOnItsSeedAloneAndSleepsInUse) {
  const auto network = make_network(small_options(GetParam().architecture), 1);
  const torch::NoGradGuard no_gradient;
  for (torch::Tensor& parameter : network->parameters()) parameter.add_(0.1);  // an answer that is not 0
  const torch::Tensor patches = torch::rand({2, 1, 32, 32});
  const auto forward = [&](std::uint64_t seed) {
    network->seed_dropout(seed);
    return network->forward(patches);
  };
  EXPECT_TRUE(torch::equal(forward(1), forward(1)));
  EXPECT_FALSE(torch::equal(forward(1), forward(2)));
  network->eval();
  EXPECT_TRUE(torch::equal(forward(1), forward(2)));
}

TEST_P(PaperNetworks, Learn32SamplesByHeart) {
  const TemporaryFolder folder;
  NetworkOptions network = small_options(GetParam().architecture);
  network.paper.dropout = 0.0;
  network.paper.hidden_units = 128;
  network.paper.subspace_units = 32;  // 32 poses at random lie in no linear space of fewer dimensions
  NetworkTrainingOptions options = testing::short_training();
  options.epochs = 800;
  options.batch_size = 32;  // norms then see in training what they see in use
  options.shards = 1;
  options.validate_every = 400;
  options.average_decay = 0.9;
  options.gradient_clip = 0.0;
  options.learning_rate.learning_rate = 1e-2;
  const CubeSamples samples = testing::made_up_samples(32, kJointBehindSkinMm);
  const auto metrics = train_network(network, options, testing::no_augmentation(), {TrainingCrops{samples}},
                                     samples, testing::run_in(folder.path(), "net"));
  EXPECT_LT(metrics.back().validation[kFirstLook], 1.0);
}

TEST_P(PaperNetworks, RefuseShardsOfASingleSample) {
  const TemporaryFolder folder;
  NetworkTrainingOptions options = testing::short_training();
  options.batch_size = options.shards = 2;
  const CubeSamples samples = testing::made_up_samples(8);
  EXPECT_THAT(testing::error_of([&] {
                train_network(small_options(GetParam().architecture), options, testing::no_augmentation(),
                              {TrainingCrops{samples}}, samples, testing::run_in(folder.path(), "net"));
              }),
              ::testing::HasSubstr("at least 2 samples per shard"));
}

TEST(FullyConnected, AnswersNothingAtFirstAndDoesNotMindItsInputsScale) {
  const ConnectedLayer hidden{40, ConnectedLayer::Activation::hidden};
  FullyConnected layers(50, {hidden, {3, ConnectedLayer::Activation::linear}}, 0.0);
  const torch::NoGradGuard no_gradient;
  torch::manual_seed(3);
  const torch::Tensor input = 5.0 + 0.1 * torch::randn({200, 50});
  EXPECT_TRUE(torch::equal(layers.forward(input), torch::zeros({200, 3})));
  FullyConnected features(50, {hidden}, 0.0);
  const torch::Tensor values = features.forward(input);
  EXPECT_TRUE(torch::allclose(values, features.forward(3.0 * input - 100.0), 1e-3, 1e-3));
  EXPECT_TRUE((values > 0).any(0).all().item<bool>()) << "each unit answers to some input";
}

TEST(FullyConnected, DropoutLeavesOutItsShareAndKeepsTheMean) {
  FullyConnected layers(1, {{20000, ConnectedLayer::Activation::hidden}}, 0.3);
  const torch::NoGradGuard no_gradient;
  for (torch::Tensor& parameter : layers.parameters()) parameter.fill_(1.0);
  layers.seed_dropout(1);
  const torch::Tensor input =
      torch::tensor({{1.0f}, {-1.0f}});  // the norm makes 1 and -1 of them, and adds 1
  const torch::Tensor values = layers.forward(input)[0];
  EXPECT_NEAR((values == 0).to(torch::kFloat).mean().item<double>(), 0.3, 0.02);
  EXPECT_NEAR(values.mean().item<double>(), 2.0, 0.05);
  layers.eval();
  EXPECT_GT(layers.forward(input)[0].min().item<double>(), 0.0);
}

class HeatMapTargets : public ::testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(, HeatMapTargets, ::testing::Values("gaussian", "mean_shift"));

TEST_P(HeatMapTargets, ComeBackAsTheJointsTheyWereMadeOf) {
  NetworkOptions options = small_options("heatmap25d");
  options.paper.peak = GetParam();
  HeatMapNetwork network(options);
  torch::manual_seed(2);
  const torch::Tensor joints = 1.2 * torch::rand({3, kTestJoints, 3}) - 0.6;
  const torch::Tensor targets = network.targets(joints);
  const torch::Tensor patches = torch::ones({3, 1, 32, 32});
  const NetworkAnswer answer = network.decode(targets, patches);
  EXPECT_TRUE(torch::allclose(answer.joints, joints, 0.0, 5e-3));
  EXPECT_EQ(network.loss(targets, patches, joints).item<float>(), 0.0f);
  EXPECT_TRUE((answer.confidence > 0.7).all().item<bool>());
}

TEST(HeatMapNetwork, JointsThatAreNotKnownDoNotCountInTheLoss) {
  for (const char* const architecture : {"heatmap2d", "heatmap25d"}) {
    HeatMapNetwork network(small_options(architecture));
    torch::manual_seed(3);
    torch::Tensor joints = 1.2 * torch::rand({2, kTestJoints, 3}) - 0.6;
    const torch::Tensor targets = network.targets(joints);
    const torch::Tensor output = targets + 0.1 * torch::rand_like(targets);
    // What each joint's cells are off by, itself alone being known.
    const auto loss_with = [&](const std::vector<int>& known) {
      torch::Tensor some = torch::full_like(joints, std::numeric_limits<float>::quiet_NaN());
      for (const int joint : known) some[1][joint] = joints[1][joint];
      return network.loss(output, {}, some).item<double>();
    };
    EXPECT_GT(loss_with({0}), 0.0);
    EXPECT_NE(loss_with({0}), loss_with({2}));
    EXPECT_NEAR(loss_with({0, 2}), 0.5 * (loss_with({0}) + loss_with({2})), 1e-6) << "the mean of the known";
    EXPECT_EQ(loss_with({}), 0.0);
  }
}

TEST(HeatMapNetwork, LooksUpTheDepthWhereItPredictsNone) {
  const NetworkOptions options = small_options("heatmap2d");
  HeatMapNetwork network(options);
  const torch::Tensor joints = torch::zeros({1, kTestJoints, 3});
  torch::Tensor patches = torch::ones({1, 1, 32, 32});
  patches[0][0][16][16] = -0.25;
  const torch::Tensor found = network.decode(network.targets(joints), patches).joints;
  const double behind_skin = kJointBehindSkinMm / (0.5 * options.patch.cube_mm);
  EXPECT_TRUE(torch::allclose(found.select(2, 2), torch::full({1, kTestJoints}, -0.25 + behind_skin)));
}

}  // namespace
}  // namespace knuckle
