// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/dense_network.h"

#include <map>

#include <torch/utils.h>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/training/loss_gradient_testing.h"

namespace knuckle {
namespace {

using testing::small_network;

constexpr int64_t kJoints = testing::kTestJoints;
constexpr int64_t kSize = 32;
constexpr int64_t kMaps = kSize / 4;

/// Cells of the map that a layer's convolution is moved over, by the first part of the layer's name.
std::map<std::string, int64_t> cells_of_layers(int64_t size) {
  const auto squared = [&](int64_t part) { return (size / part) * (size / part); };
  return {{"stem", squared(2)},      {"down1", squared(4)},     {"block1_0", squared(4)},
          {"down2", squared(8)},     {"block2_0", squared(8)},  {"down3", squared(16)},
          {"block3_0", squared(16)}, {"lateral2", squared(16)}, {"smooth2", squared(8)},
          {"lateral1", squared(8)},  {"smooth1", squared(4)},   {"head", squared(4)}};
}

TEST(DenseNetwork, TheDefaultKeepsToItsBudget) {
  const NetworkOptions options;
  const auto network = make_network(options, 1);
  std::map<std::string, int64_t> cells = cells_of_layers(options.patch.size_px);
  int64_t parameters = 0;
  int64_t products = 0;
  for (const auto& item : network->named_parameters()) {
    parameters += item.value().numel();
    const std::string layer = item.key().substr(0, item.key().find('.'));
    ASSERT_TRUE(cells.contains(layer)) << item.key();
    if (item.value().dim() == 4) products += item.value().numel() * cells[layer];
  }
  EXPECT_EQ(parameters, 558750) << "as docs/networks.md says";
  EXPECT_EQ(products, 61304832) << "as docs/networks.md says";
  EXPECT_LE(parameters, 3'000'000);
  EXPECT_LE(products, 250'000'000);
}

TEST(DenseNetwork, ShapesOfOutputAndAnswer) {
  const auto network = make_network(small_network(), 1);
  const torch::Tensor patches = torch::rand({3, 1, kSize, kSize}) - 0.5;
  const torch::Tensor output = network->forward(patches);
  EXPECT_EQ(output.sizes(), torch::IntArrayRef({3, 5 * kJoints, kMaps, kMaps}));
  const NetworkAnswer answer = network->decode(output, patches);
  EXPECT_EQ(answer.joints.sizes(), torch::IntArrayRef({3, kJoints, 3}));
  EXPECT_EQ(answer.confidence.sizes(), torch::IntArrayRef({3, kJoints}));
  EXPECT_TRUE((answer.confidence >= 0).all().item<bool>() && (answer.confidence <= 1).all().item<bool>());
}

TEST(DenseNetwork, APatchOfNothingButBackgroundGivesNumbers) {
  const auto network = make_network(small_network(), 1);
  network->eval();
  const torch::Tensor patches = torch::ones({1, 1, kSize, kSize});
  const torch::Tensor output = network->forward(patches);
  EXPECT_TRUE(torch::isfinite(network->decode(output, patches).joints).all().item<bool>());
  const torch::Tensor joints = torch::zeros({1, kJoints, 3});
  EXPECT_TRUE(torch::isfinite(network->loss(output, patches, joints)).all().item<bool>());
}

TEST(DenseNetwork, FindsTheJointsThatTrueVotesPointAt) {
  const NetworkOptions options = small_network();
  const auto network = make_network(options, 1);
  torch::manual_seed(3);
  const torch::Tensor patches = torch::rand({2, 1, kSize, kSize}) - 0.5;
  const torch::Tensor joints = 0.5 * torch::rand({2, kJoints, 3}) - 0.25;
  // Where each cell is: the nearest of its 16 pixels; the cells' centres in the patch's coordinates.
  const torch::Tensor depth = -torch::max_pool2d(-patches, {4, 4});
  const torch::Tensor centres = (torch::arange(kMaps) * 4 + 1.5) / (0.5 * (kSize - 1)) - 1.0;
  const torch::Tensor u = centres.view({1, 1, 1, kMaps}).expand({2, kJoints, kMaps, kMaps});
  const torch::Tensor v = centres.view({1, 1, kMaps, 1}).expand({2, kJoints, kMaps, kMaps});
  const torch::Tensor points = torch::stack({u, v, depth.expand({2, kJoints, kMaps, kMaps})}, 1);
  const torch::Tensor to_joint = joints.transpose(1, 2).view({2, 3, kJoints, 1, 1}) - points;
  const torch::Tensor distance = to_joint.norm(2, {1}, true);
  const torch::Tensor closeness = 1.0 - distance / options.dense.kernel;
  const torch::Tensor weight = torch::randn({2, 1, kJoints, kMaps, kMaps});
  const torch::Tensor output =
      torch::cat({to_joint / distance, closeness, weight}, 1).view({2, 5 * kJoints, kMaps, kMaps});
  const NetworkAnswer answer = network->decode(output, patches);
  EXPECT_TRUE(torch::allclose(answer.joints, joints, 0.0, 1e-5));
  EXPECT_TRUE(torch::allclose(answer.confidence, torch::ones({2, kJoints}), 0.0, 1e-3));
  EXPECT_LT(network->loss(output, patches, joints).item<double>(), 1e-6);
}

TEST(DenseNetwork, TheLossHasTheGradientOfFiniteDifferences) {
  const auto network = make_network(small_network(), 1);
  torch::manual_seed(4);
  const torch::Tensor patches =
      torch::rand({2, 1, kSize, kSize}, torch::kDouble) * 1.5 - 0.2;  // some background
  torch::Tensor joints = torch::rand({2, kJoints, 3}, torch::kDouble) - 0.5;
  joints[1][2].fill_(kNaN);
  testing::expect_gradient_of_finite_differences(
      *network, patches, joints, 0.3 * torch::randn({2, 5 * kJoints, kMaps, kMaps}, torch::kDouble));
}

TEST(DenseNetwork, HasTheSameLossInSingleAndInDoublePrecision) {
  // Double precision takes LibTorch's own operations: the reference.
  const auto network = make_network(small_network(), 1);
  torch::manual_seed(6);
  torch::Tensor patches = torch::rand({3, 1, kSize, kSize}) * 1.5 - 0.2;
  patches[1].fill_(1.0);  // a sample without hand
  torch::Tensor joints = torch::rand({3, kJoints, 3}) - 0.5;
  joints[2][0][1] = kNaN;
  const torch::Tensor output = torch::randn({3, 5 * kJoints, kMaps, kMaps});
  const torch::Tensor single = output.clone().set_requires_grad(true);
  const torch::Tensor reference = output.to(torch::kDouble).set_requires_grad(true);
  const torch::Tensor loss = network->loss(single, patches, joints);
  const torch::Tensor expected =
      network->loss(reference, patches.to(torch::kDouble), joints.to(torch::kDouble));
  EXPECT_NEAR(loss.item<double>(), expected.item<double>(), 1e-5 * expected.item<double>());
  (2.0 * loss).backward();
  (2.0 * expected).backward();
  EXPECT_TRUE(torch::allclose(single.grad().to(torch::kDouble), reference.grad(), 1e-3, 1e-6));
}

NetworkOptions network_that_tells_sides() {
  NetworkOptions options = small_network();
  options.dense.tells_side = true;
  return options;
}

/// Targets of joints and sides: one row more, whose first number is the side.
torch::Tensor with_sides(const torch::Tensor& joints, const std::vector<double>& is_right) {
  torch::Tensor targets = torch::zeros({joints.size(0), kJoints + 1, 3}, joints.options());
  targets.narrow(1, 0, kJoints).copy_(joints);
  for (std::size_t i = 0; i < is_right.size(); ++i)
    targets[static_cast<int64_t>(i)][kJoints].fill_(is_right[i]);
  return targets;
}

TEST(DenseNetwork, TheLossOfSidesHasTheGradientOfFiniteDifferences) {
  const auto network = make_network(network_that_tells_sides(), 1);
  torch::manual_seed(8);
  const torch::Tensor patches = torch::rand({2, 1, kSize, kSize}, torch::kDouble) * 1.5 - 0.2;
  torch::Tensor joints = torch::rand({2, kJoints, 3}, torch::kDouble) - 0.5;
  joints[1].fill_(kNaN);  // a left hand: only its side is learned
  testing::expect_gradient_of_finite_differences(
      *network, patches, with_sides(joints, {1.0, 0.0}),
      0.3 * torch::randn({2, 5 * kJoints + 1, kMaps, kMaps}, torch::kDouble));
}

TEST(DenseNetwork, TheLossOfSidesAndHandsHasTheGradientOfFiniteDifferences) {
  NetworkOptions options = network_that_tells_sides();
  options.dense.tells_hand = true;
  const auto network = make_network(options, 1);
  torch::manual_seed(11);
  const torch::Tensor patches = torch::rand({3, 1, kSize, kSize}, torch::kDouble) * 1.5 - 0.2;
  torch::Tensor targets = torch::rand({3, kJoints + 2, 3}, torch::kDouble) - 0.5;
  targets.narrow(1, kJoints, 2).fill_(1.0);
  targets[2].fill_(kNaN);  // a thing
  targets[2][kJoints + 1].fill_(0.0);
  testing::expect_gradient_of_finite_differences(
      *network, patches, targets, 0.3 * torch::randn({3, 5 * kJoints + 2, kMaps, kMaps}, torch::kDouble));
}

TEST(DenseNetwork, AnAnswersEntropyCountsByItsWeight) {
  torch::manual_seed(13);
  const torch::Tensor patches = torch::rand({2, 1, kSize, kSize}) - 0.5;
  const torch::Tensor output = torch::zeros({2, 5 * kJoints + 1, kMaps, kMaps});
  const torch::Tensor joints = torch::full({2, kJoints, 3}, kNaN);
  for (const double weight : {0.0, 0.05, 2.0}) {
    NetworkOptions options = network_that_tells_sides();
    options.dense.question_weight = weight;
    const torch::Tensor loss =
        make_network(options, 1)->loss(output, patches, with_sides(joints, {1.0, 0.0}));
    EXPECT_NEAR(loss.item<double>(), weight * std::log(2.0), 1e-6) << "one half says one bit";
  }
}

TEST(DenseNetwork, OfAThingOnlyThatItIsNoHandIsLearned) {
  NetworkOptions options = network_that_tells_sides();
  options.dense.tells_hand = true;
  const auto network = make_network(options, 1);
  torch::manual_seed(12);
  const torch::Tensor patches = torch::rand({1, 1, kSize, kSize}) - 0.5;
  torch::Tensor output = torch::randn({1, 5 * kJoints + 2, kMaps, kMaps});
  output.set_requires_grad(true);
  torch::Tensor targets = torch::full({1, kJoints + 2, 3}, kNaN);
  targets[0][kJoints + 1].fill_(0.0);
  network->loss(output, patches, targets).backward();
  const torch::Tensor slopes = output.grad()[0];
  EXPECT_EQ(slopes.narrow(0, 0, 5 * kJoints + 1).abs().sum().item<float>(), 0.0f);
  EXPECT_TRUE((slopes[5 * kJoints + 1] > 0).all().item<bool>()) << "less of a hand";
}

TEST(DenseNetwork, OfALeftHandOnlyTheSideIsLearned) {
  const auto network = make_network(network_that_tells_sides(), 1);
  torch::manual_seed(9);
  torch::Tensor patches = torch::rand({1, 1, kSize, kSize}) - 0.5;
  patches[0][0].narrow(1, 0, kSize / 2).fill_(kCubeBackground);  // the left half is no hand
  torch::Tensor output = torch::randn({1, 5 * kJoints + 1, kMaps, kMaps});
  output.set_requires_grad(true);
  const torch::Tensor joints = torch::full({1, kJoints, 3}, kNaN);
  network->loss(output, patches, with_sides(joints, {0.0})).backward();
  const torch::Tensor slopes = output.grad()[0];
  EXPECT_EQ(slopes.narrow(0, 0, 5 * kJoints).abs().sum().item<float>(), 0.0f);
  EXPECT_EQ(slopes[5 * kJoints].narrow(1, 0, kMaps / 2).abs().sum().item<float>(), 0.0f);
  EXPECT_TRUE((slopes[5 * kJoints].narrow(1, kMaps / 2, kMaps / 2) > 0).all().item<bool>()) << "less right";
}

TEST(DenseNetwork, JointsAreLearnedTheSameBesideSides) {
  const auto network = make_network(small_network(), 1);
  const auto sided = make_network(network_that_tells_sides(), 1);
  torch::manual_seed(10);
  const torch::Tensor patches = torch::rand({2, 1, kSize, kSize}) * 1.5 - 0.2;
  const torch::Tensor joints = torch::rand({2, kJoints, 3}) - 0.5;
  const torch::Tensor output = torch::randn({2, 5 * kJoints + 1, kMaps, kMaps});
  const torch::Tensor of_joints = output.narrow(1, 0, 5 * kJoints).contiguous().set_requires_grad(true);
  const torch::Tensor of_all = output.clone().set_requires_grad(true);
  network->loss(of_joints, patches, joints).backward();
  sided->loss(of_all, patches, with_sides(joints, {1.0, 1.0})).backward();
  EXPECT_TRUE(torch::allclose(of_joints.grad(), of_all.grad().narrow(1, 0, 5 * kJoints), 1e-5, 1e-9));
  const NetworkAnswer answer = sided->decode(output, patches);
  EXPECT_TRUE(torch::allclose(answer.joints, network->decode(of_joints, patches).joints));
  EXPECT_EQ(answer.right_hand.sizes(), torch::IntArrayRef({2}));
}

TEST(DenseNetwork, AJointThatIsNotKnownHasNoGradient) {
  const auto network = make_network(small_network(), 1);
  const torch::Tensor patches = torch::rand({1, 1, kSize, kSize}) - 0.5;
  torch::Tensor joints = torch::zeros({1, kJoints, 3});
  joints[0][2][1] = kNaN;
  torch::Tensor output = torch::randn({1, 5 * kJoints, kMaps, kMaps});
  output.set_requires_grad(true);
  network->loss(output, patches, joints).backward();
  const torch::Tensor a_joint = output.grad().view({5, kJoints, -1}).abs().sum(torch::IntArrayRef({0, 2}));
  for (int64_t j = 0; j < kJoints; ++j) {
    EXPECT_EQ(a_joint[j].item<float>() > 0.0f, j != 2) << j;
  }
}

TEST(DenseNetwork, WeightsDependOnTheSeedAlone) {
  const auto weights = [](std::uint64_t seed) {
    return make_network(small_network(), seed)->parameters().front();
  };
  EXPECT_TRUE(torch::equal(weights(1), weights(1)));
  EXPECT_FALSE(torch::equal(weights(1), weights(2)));
}

}  // namespace
}  // namespace knuckle
