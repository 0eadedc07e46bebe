// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/network_writer.h"

#include <algorithm>

#include <torch/serialize.h>
#include <torch/utils.h>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/training/archive.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::small_network;
using testing::TemporaryFolder;

class NetworkWriter : public ::testing::TestWithParam<std::string_view> {
 protected:
  NetworkWriter() { options_.architecture = GetParam(); }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "file.pt";
  NetworkOptions options_ = small_network();
};

INSTANTIATE_TEST_SUITE_P(, NetworkWriter, ::testing::ValuesIn(network_architectures()),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(NetworkWriter, WritesWhatIsReadWithoutLibTorch) {
  const auto network = make_network(options_, 1);
  network->forward(torch::rand({4, 1, 32, 32}));  // statistics
  save_network(file_, options_, *network);
  const NetworkWeights read = load_network_weights(file_);
  EXPECT_EQ(network_options_as_toml(read.options()), network_options_as_toml(options_));
  std::size_t arrays = 0;
  for (const auto& item : network->named_parameters()) {
    const torch::Tensor values = item.value().detach().to(torch::kHalf).to(torch::kFloat).contiguous();
    const std::span<const float> expected(values.data_ptr<float>(), static_cast<std::size_t>(values.numel()));
    EXPECT_TRUE(std::ranges::equal(read.floats(item.key()), expected)) << item.key();
    ++arrays;
  }
  for (const auto& item : network->named_buffers()) {
    if (!item.value().is_floating_point()) continue;  // how often it was in training
    const torch::Tensor values = item.value().contiguous();
    const std::span<const float> expected(values.data_ptr<float>(), static_cast<std::size_t>(values.numel()));
    EXPECT_TRUE(std::ranges::equal(read.singles(item.key()), expected)) << item.key();
    ++arrays;
  }
  EXPECT_EQ(arrays, read.arrays().size());
}

TEST_P(NetworkWriter, RefusesANetworkThatIsNotItsOptions) {
  const auto network = make_network(options_, 1);
  NetworkOptions other = options_;
  other.convention = "icg20";
  EXPECT_THAT(error_of([&] { save_network(file_, other, *network); }), HasSubstr("another shape"));
  other.architecture = GetParam() == "dense" ? "regression" : "dense";
  EXPECT_THAT(error_of([&] { save_network(file_, other, *network); }), HasSubstr("it has no "));
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_THAT(error_of([&] { save_network("/proc/knuckle/net.pt", options_, *network); }),
              HasSubstr("/proc/knuckle/net.pt"));
}

class ForeignArchive : public ::testing::Test {
 protected:
  std::string fault() const {
    return error_of([&] { load_network_weights(file_); });
  }
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "file.pt";
};

TEST_F(ForeignArchive, IsToldApart) {
  ArchiveWriter("knuckle-network", 2).save(file_);
  EXPECT_THAT(fault(), AllOf(HasSubstr("file.pt"), HasSubstr("an archive of LibTorch"), HasSubstr("0.1")));
  ArchiveWriter("knuckle-network-checkpoint", 1).save(file_);
  EXPECT_THAT(fault(), AllOf(HasSubstr("file.pt"), HasSubstr("checkpoint")));
  torch::save(torch::zeros({2}), file_.string());
  EXPECT_THAT(fault(), AllOf(HasSubstr("file.pt"), HasSubstr("an archive of LibTorch")));
}

TEST_F(ForeignArchive, WeightsBeyondHalfPrecisionAreFoundWhenRead) {
  const auto network = make_network(small_network(), 1);
  {
    const torch::NoGradGuard no_gradient;
    network->parameters().front().fill_(1e30f);
  }
  save_network(file_, small_network(), *network);
  EXPECT_THAT(fault(), AllOf(HasSubstr("stem.convolution.weight"), HasSubstr("not finite")));
}

}  // namespace
}  // namespace knuckle
