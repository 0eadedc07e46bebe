// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/pose_network.h"

#include <limits>

#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::small_network;

Image<float> diagonal_patch(double scale = 0.01) {
  Image<float> patch(32, 32, kCubeBackground);
  for (int i = 0; i < 32; ++i) patch(i, i) = static_cast<float>(scale * i);
  return patch;
}

void expect_same(const NetworkPrediction& a, const NetworkPrediction& b) {
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t j = 0; j < a.joints.size(); ++j) {
    EXPECT_EQ(a.joints[j].u, b.joints[j].u);
    EXPECT_EQ(a.joints[j].v, b.joints[j].v);
    EXPECT_EQ(a.joints[j].d, b.joints[j].d);
  }
  EXPECT_EQ(a.confidence, b.confidence);
}

class EveryArchitecture : public ::testing::TestWithParam<std::string_view> {
 protected:
  NetworkOptions options() const {
    NetworkOptions options = small_network();
    options.architecture = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(PoseNetwork, EveryArchitecture, ::testing::ValuesIn(network_architectures()),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(EveryArchitecture, PredictsTheSameOnManyThreads) {
  const PoseNetwork network(options(), 1);
  const NetworkPrediction expected = network.predict(diagonal_patch());
  EXPECT_EQ(expected.joints.size(), 14u);
  std::vector<NetworkPrediction> found(16);
  parallel_for(16, [&](std::int64_t i) {
    (void)network.predict(diagonal_patch(0.001 * static_cast<double>(i)));  // others leave nothing behind
    found[static_cast<std::size_t>(i)] = network.predict(diagonal_patch());
  });
  for (const NetworkPrediction& prediction : found) expect_same(prediction, expected);
}

TEST_P(EveryArchitecture, IsTheSameFromItsFile) {
  const testing::TemporaryFolder folder;
  save_network_weights(folder / "net.pt", random_weights(options(), 4));
  PoseNetwork read(folder / "net.pt");
  EXPECT_EQ(read.options().architecture, GetParam());
  const PoseNetwork moved = std::move(read);
  expect_same(moved.predict(diagonal_patch()), PoseNetwork(options(), 4).predict(diagonal_patch()));
}

TEST_P(EveryArchitecture, SeesItsPatch) {
  const PoseNetwork network(options(), 1);
  EXPECT_NE(network.predict(diagonal_patch()).joints[0].d, network.predict(diagonal_patch(0.02)).joints[0].d);
}

TEST(PoseNetwork, RefusesAPatchOfAnotherSizeOrWithNaN) {
  const PoseNetwork network(small_network(), 1);
  EXPECT_THAT(error_of([&] { (void)network.predict(Image<float>(96, 96)); }),
              HasSubstr("a patch of 96 x 96, expected 32 x 32"));
  Image<float> patch(32, 32);
  patch(3, 4) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(error_of([&] { (void)network.predict(patch); }),
              HasSubstr("a pixel of the patch is not finite"));
}

TEST(PoseNetwork, ReportsAJointThatIsNotFinite) {
  NetworkWeights weights = random_weights(small_network(), 1);
  for (const NetworkArray& array : weights.arrays()) {
    if (!array.name.ends_with(".norm.weight")) continue;
    for (Half& half : weights.halves(array.name)) half = half_of_float(60000.0f);
  }
  const PoseNetwork network(weights);
  EXPECT_THAT(error_of([&] { (void)network.predict(diagonal_patch()); }),
              HasSubstr("a joint it predicts is not finite"));
}

}  // namespace
}  // namespace knuckle
