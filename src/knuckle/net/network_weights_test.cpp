// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_weights.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;
using testing::small_network;

NetworkOptions options_of(std::string_view architecture) {
  NetworkOptions options;
  options.architecture = architecture;
  options.convention = "icg20";
  return options;
}

TEST(NetworkArrays, AreAsManyAsTheDocumentationSays) {
  EXPECT_EQ(total_sizes(network_arrays(NetworkOptions{})).halves, 558750);
  EXPECT_EQ(total_sizes(network_arrays(NetworkOptions{})).singles, 1824) << "a mean and a variance a channel";
  const auto millions = [](std::string_view architecture) {
    const double count = static_cast<double>(total_sizes(network_arrays(options_of(architecture))).halves);
    return std::round(count / 1e5) / 10.0;
  };
  EXPECT_EQ(millions("heatmap2d"), 58.4);
  EXPECT_EQ(millions("heatmap25d"), 60.5);
  EXPECT_EQ(millions("regression"), 48.9);
  EXPECT_EQ(millions("pca"), 48.8);
  EXPECT_EQ(millions("autoencoder"), 49.1);
}

TEST(NetworkWeights, AreSharedByNameAndWhole) {
  NetworkWeights weights(small_network());
  weights.halves("head.bias")[0] = half_of_float(0.5f);
  const std::size_t place = weights.halves().size() - weights.halves("head.bias").size();
  EXPECT_EQ(weights.halves()[place], half_of_float(0.5f));
  EXPECT_EQ(weights.floats("head.bias")[0], 0.5f);
  weights.singles("stem.norm.running_var")[0] = 3.0f;
  EXPECT_EQ(weights.singles()[8], 3.0f) << "after the stem's 8 means";
}

TEST(RandomWeights, DependOnTheSeedAloneAndHaveTheirDeviation) {
  const NetworkWeights weights = random_weights(NetworkOptions{}, 1);
  EXPECT_TRUE(std::ranges::equal(weights.halves(), random_weights(NetworkOptions{}, 1).halves()));
  EXPECT_FALSE(std::ranges::equal(weights.halves(), random_weights(NetworkOptions{}, 2).halves()));
  const std::string name = "block3_0.first.convolution.weight";  // 128 x 128 x 3 x 3
  double squares = 0.0;
  for (const float weight : weights.floats(name)) squares += weight * weight;
  EXPECT_NEAR(squares / 147456.0, 2.0 / 1152.0, 2e-5);
  EXPECT_NE(weights.floats(name)[0], weights.floats("block3_0.second.convolution.weight")[0]);
  EXPECT_EQ(weights.singles("stem.norm.running_var")[3], 1.0f);
}

TEST(RandomWeights, RefuseOptionsOutOfRange) {
  NetworkOptions options;
  options.dense.blocks = 0;
  EXPECT_THAT(error_of([&] { random_weights(options, 1); }), HasSubstr("blocks"));
}

}  // namespace
}  // namespace knuckle
