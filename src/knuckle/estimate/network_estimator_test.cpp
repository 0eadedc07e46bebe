// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/network_estimator.h"

#include "knuckle/core/testing.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::small_network;

/// A hand as a pipeline would cut it out.
HandPatch small_patch() {
  const CubeSamples samples = testing::made_up_samples(1);
  HandPatch patch;
  patch.pixels = Image<float>(testing::kTestCube.size_px, testing::kTestCube.size_px);
  Random unused(0);
  CubeViewer(samples).view_pixels(samples.sample(0), {}, {}, unused, patch.pixels.pixels());
  return patch;
}

class EveryNetwork : public ::testing::TestWithParam<std::string_view> {
 protected:
  NetworkOptions network() const {
    NetworkOptions options = small_network();
    options.architecture = GetParam();
    return options;
  }
};

INSTANTIATE_TEST_SUITE_P(Estimators, EveryNetwork, ::testing::ValuesIn(network_architectures()),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(EveryNetwork, SaysAsAnEstimatorWhatItSaysAsANetwork) {
  const HandPatch patch = small_patch();
  const NetworkPrediction expected = PoseNetwork(network(), 3).predict(patch.pixels);
  const NetworkEstimator estimator(PoseNetwork(network(), 3), {});
  EXPECT_EQ(estimator.convention().name, "nyu14");
  EXPECT_EQ(estimator.patches().options(), small_network().patch);
  EXPECT_EQ(estimator.patches().options().size_px, 32);
  EXPECT_EQ(estimator.passes(), 2);
  EXPECT_EQ(estimator.sure_confidence(), GetParam() == "dense" ? 0.45 : 0.0);
  const PatchPose pose = estimator.estimate(patch);
  ASSERT_EQ(pose.joints.size(), 14u);
  EXPECT_EQ(pose.confidence, expected.confidence);
  for (std::size_t j = 0; j < pose.joints.size(); ++j) {
    EXPECT_EQ(pose.joints[j].u, expected.joints[j].u);
    EXPECT_EQ(pose.joints[j].d, expected.joints[j].d);
  }
}

TEST_P(EveryNetwork, IsAnEstimatorByName) {
  EXPECT_NE(std::ranges::find(estimator_names(), GetParam()), estimator_names().end());
}

TEST(NetworkEstimator, ChecksItsOptions) {
  EXPECT_THAT(error_of([] { NetworkEstimator(PoseNetwork(small_network(), 1), {.passes = 0}); }),
              HasSubstr("passes"));
  EXPECT_THAT(error_of([] { NetworkEstimator(PoseNetwork(small_network(), 1), {.passes = 6}); }),
              HasSubstr("passes"));
}

class CreateNetworkEstimator : public ::testing::Test {
 protected:
  CreateNetworkEstimator() { save_network_weights(folder_ / "small.pt", random_weights(small_network(), 1)); }

  std::unique_ptr<Estimator> create(const std::string& toml) const {
    write_text_file(folder_ / "p.toml", "model = \"small.pt\"\n" + toml);
    return create_estimator(OptionTable::load(folder_ / "p.toml"));
  }
  std::string fault(const std::string& toml) const {
    return error_of([&] { create(toml); });
  }

  testing::TemporaryFolder folder_;
};

TEST_F(CreateNetworkEstimator, ReadsThePasses) {
  EXPECT_EQ(create("method = \"dense\"\npasses = 3\n")->passes(), 3);
  EXPECT_EQ(create("method = \"dense\"\nconvention = \"nyu14\"\npatch_size_px = 32\n")->passes(), 2);
}

TEST_F(CreateNetworkEstimator, NamesWhatIsWrong) {
  EXPECT_THAT(fault("method = \"dense\"\npasses = 9\n"), AllOf(HasSubstr("p.toml:3"), HasSubstr("passes")));
  EXPECT_THAT(fault("method = \"regression\"\n"),
              AllOf(HasSubstr("small.pt is a network \"dense\""), HasSubstr("\"regression\"")));
  EXPECT_THAT(fault("method = \"dense\"\nconvention = \"icg20\"\n"),
              AllOf(HasSubstr("icg20"), HasSubstr("nyu14")));
  EXPECT_THAT(fault("method = \"dense\"\npatch_size_px = 96\n"), HasSubstr("32 x 32"));
  EXPECT_THAT(fault("method = \"forest\"\n"), HasSubstr("small.pt"));
}

}  // namespace
}  // namespace knuckle
