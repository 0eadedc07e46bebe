// SPDX-License-Identifier: Apache-2.0
// The networks that are trained and those that answer are the same: LibTorch's forward and decoding against
// Knuckle's own inference from the written file.
#include <cmath>

#include <torch/utils.h>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/pose_network.h"
#include "knuckle/training/network_writer.h"

namespace knuckle {
namespace {

using testing::small_network;
using testing::TemporaryFolder;

/// Weights of half precision, and batch norms as a training leaves them.
void make_like_trained(NetworkModule& network) {
  const torch::NoGradGuard no_gradient;
  torch::manual_seed(5);
  for (const auto& item : network.named_parameters()) {
    torch::Tensor parameter = item.value();
    const std::string& name = item.key();
    if (name.ends_with("norm.weight")) parameter.uniform_(0.5, 1.5);
    if (name.ends_with(".bias")) parameter.uniform_(-0.2, 0.2);
    if (name == "head.weight") parameter.normal_(0.0, 0.1);  // votes that differ
    parameter.copy_(parameter.to(torch::kHalf).to(torch::kFloat));
  }
  for (const auto& item : network.named_buffers()) {
    torch::Tensor buffer = item.value();
    if (item.key().ends_with("running_mean")) buffer.uniform_(-0.5, 0.5);
    if (item.key().ends_with("running_var")) buffer.uniform_(0.3, 3.0);
  }
  network.eval();
}

/// A surface with holes, before background.
Image<float> made_up_patch(int size, std::uint64_t seed) {
  Random random(seed);
  Image<float> patch(size, size, kCubeBackground);
  for (int row = size / 8; row < size - size / 5; ++row) {
    for (int column = size / 6; column < size - size / 6; ++column) {
      if (random.uniform() < 0.1) continue;
      const double wave = 0.5 * std::sin(0.2 * column + 0.1 * static_cast<double>(seed) * row);
      patch(column, row) = static_cast<float>(wave + 0.1 * random.normal());
    }
  }
  return patch;
}

struct NetworkCase {
  std::string name;
  NetworkOptions options;
};

std::vector<NetworkCase> cases() {
  std::vector<NetworkCase> cases;
  for (const std::string_view architecture : network_architectures()) {
    NetworkOptions options = small_network();
    options.architecture = architecture;
    cases.push_back({std::string(architecture) + "_small", options});
    options = {};
    options.architecture = architecture;
    options.convention = architecture == "dense" ? "knuckle22" : "icg20";
    options.paper.hidden_units = 256;  // of 4096: that takes long
    cases.push_back({std::string(architecture) + "_96", options});
  }
  NetworkOptions odd = small_network();
  odd.patch.size_px = 48;
  odd.dense = {.stem_channels = 1,
               .quarter_channels = 3,
               .eighth_channels = 17,
               .sixteenth_channels = 9,
               .head_channels = 5,
               .blocks = 2,
               .kernel = 1.3};
  cases.push_back({"dense_odd", odd});
  odd.dense.tells_side = true;
  cases.push_back({"dense_with_side", odd});
  odd.dense.tells_hand = true;
  cases.push_back({"dense_with_side_and_hand", odd});
  odd.dense.tells_side = false;
  cases.push_back({"dense_with_hand", odd});
  odd.architecture = "heatmap25d";
  odd.paper = {.first_maps = 3,
               .second_maps = 5,
               .hidden_units = 33,
               .map_cells = 7,
               .depth_bins = 6,
               .peak = "mean_shift"};
  cases.push_back({"heatmap25d_odd", odd});
  return cases;
}

class SameAnswers : public ::testing::TestWithParam<NetworkCase> {};

INSTANTIATE_TEST_SUITE_P(, SameAnswers, ::testing::ValuesIn(cases()),
                         [](const auto& instance) { return instance.param.name; });

TEST_P(SameAnswers, InTrainingAndInUse) {
  const NetworkOptions& options = GetParam().options;
  const TemporaryFolder folder;
  const auto network = make_network(options, 3);
  make_like_trained(*network);
  save_network(folder / "net.pt", options, *network);
  const PoseNetwork in_use(folder / "net.pt");
  const torch::NoGradGuard no_gradient;
  const int size = options.patch.size_px;
  for (const std::uint64_t seed : {1, 2, 3}) {
    Image<float> patch = made_up_patch(size, seed);
    const torch::Tensor input = torch::from_blob(patch.data(), {1, 1, size, size});
    const NetworkAnswer expected = network->decode(network->forward(input), input);
    const NetworkPrediction found = in_use.predict(patch);
    ASSERT_EQ(found.joints.size(), static_cast<std::size_t>(expected.joints.size(1)));
    for (std::size_t j = 0; j < found.joints.size(); ++j) {
      const torch::Tensor joint = expected.joints[0][static_cast<int64_t>(j)];
      EXPECT_NEAR(found.joints[j].u, joint[0].item<float>(), 1e-3) << j;
      EXPECT_NEAR(found.joints[j].v, joint[1].item<float>(), 1e-3) << j;
      EXPECT_NEAR(found.joints[j].d, joint[2].item<float>(), 1e-3) << j;
    }
    ASSERT_EQ(found.right_hand.has_value(), expected.right_hand.defined());
    if (found.right_hand) {
      EXPECT_NEAR(*found.right_hand, expected.right_hand[0].item<float>(), 1e-3);
    }
    ASSERT_EQ(found.hand.has_value(), expected.hand.defined());
    if (found.hand) {
      EXPECT_NEAR(*found.hand, expected.hand[0].item<float>(), 1e-3);
    }
    ASSERT_EQ(!found.confidence.empty(), expected.confidence.defined());
    for (std::size_t j = 0; j < found.confidence.size(); ++j) {
      EXPECT_NEAR(found.confidence[j], expected.confidence[0][static_cast<int64_t>(j)].item<float>(), 1e-3);
    }
  }
}

TEST(SameAnswersOnEveryKind, OfNothingButBackground) {
  NetworkOptions options = small_network();
  options.dense.tells_side = true;
  const auto network = make_network(options, 3);
  make_like_trained(*network);
  const PoseNetwork in_use(weights_of(options, *network));
  const torch::NoGradGuard no_gradient;
  const torch::Tensor input = torch::full({1, 1, 32, 32}, kCubeBackground);
  const NetworkAnswer answer = network->decode(network->forward(input), input);
  const torch::Tensor& expected = answer.joints;
  const NetworkPrediction found = in_use.predict(Image<float>(32, 32, kCubeBackground));
  EXPECT_NEAR(found.right_hand.value(), answer.right_hand[0].item<float>(), 2e-3);
  for (std::size_t j = 0; j < found.joints.size(); ++j) {
    EXPECT_NEAR(found.joints[j].u, expected[0][static_cast<int64_t>(j)][0].item<float>(), 2e-3);
    EXPECT_NEAR(found.joints[j].d, expected[0][static_cast<int64_t>(j)][2].item<float>(), 2e-3);
  }
}

}  // namespace
}  // namespace knuckle
