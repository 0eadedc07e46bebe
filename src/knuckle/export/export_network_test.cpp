// SPDX-License-Identifier: Apache-2.0
#include "knuckle/export/export_network.h"

#include <algorithm>

#include "knuckle/core/random.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/testing.h"
#include "knuckle/estimate/create_estimator.h"
#include "knuckle/estimate/network_estimator.h"
#include "knuckle/net/exported_network.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/net/onnx/onnx_check.h"
#include "knuckle/net/onnx/onnx_engine.h"
#include "knuckle/net/onnx/onnx_file.h"
#include "knuckle/net/onnx_network.h"
#include "knuckle/segment/detector/detector_relief.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/segment/detector/hand_detector.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// Of a joint, in halves of the patch: some thousandths of a millimetre.
constexpr double kRounding = 2e-5;

NetworkOptions options_of(std::string_view architecture) {
  NetworkOptions options = testing::small_network();
  options.architecture = architecture;
  options.dense.tells_side = options.dense.tells_hand = true;
  options.dense.blocks = 2;
  options.paper.map_cells = 6;
  return options;
}

/// Weights whose norms do something, and whose last layer gives clear answers.
NetworkWeights lively_weights(const NetworkOptions& options) {
  NetworkWeights weights = random_weights(options, 7);
  Random random(8, 0);
  for (float& value : weights.singles()) value = static_cast<float>(random.uniform(0.5, 1.5));
  for (const NetworkArray& array : weights.arrays()) {
    if (!array.name.ends_with(".bias")) continue;
    for (Half& bias : weights.halves(array.name))
      bias = half_of_float(static_cast<float>(random.uniform(-0.5, 0.5)));
  }
  return weights;
}

HandPatch patch_with_hand(const NetworkOptions& options, std::uint64_t id) {
  HandPatch patch;
  const int size = options.patch.size_px;
  patch.pixels = Image<float>(size, size, kCubeBackground);
  Random random(9, id);
  for (int row = size / 4; row < size / 2; ++row) {
    for (int column = size / 3; column < size - 3; ++column) {
      patch.pixels(column, row) = static_cast<float>(random.uniform(-0.9, 0.9));
    }
  }
  // The nearest float to the background still is hand.
  patch.pixels(1, 1) = std::nextafter(kCubeBackground, 0.0f);
  return patch;
}

class EveryArchitecture : public ::testing::TestWithParam<std::string_view> {
 protected:
  void SetUp() override {
    if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
    weights_ = lively_weights(options_of(GetParam()));
    save_network_weights(folder_ / "net.pt", *weights_);
    (void)export_network(folder_ / "net.pt", folder_ / "net.onnx");
    write_text_file(folder_ / "p.toml", "method = \"onnx\"\nmodel = \"net.onnx\"\n");
    estimator_ = create_estimator(OptionTable::load(folder_ / "p.toml"));
  }

  testing::TemporaryFolder folder_;
  std::optional<NetworkWeights> weights_;
  std::unique_ptr<Estimator> estimator_;
};

INSTANTIATE_TEST_SUITE_P(Export, EveryArchitecture, ::testing::ValuesIn(network_architectures()),
                         [](const auto& instance) { return std::string(instance.param); });

TEST_P(EveryArchitecture, AnswersAsOurOwnInference) {
  const PoseNetwork network(*weights_);
  for (std::uint64_t id = 0; id < 8; ++id) {
    HandPatch patch = patch_with_hand(network.options(), id);
    // Where no cell is hand all count.
    if (id == 7) std::ranges::fill(patch.pixels.pixels(), kCubeBackground);
    const NetworkPrediction expected = network.predict(patch.pixels);
    const PatchPose pose = estimator_->estimate(patch);
    // Without a hand the weights of votes are rounded at 2048 (dense_graph.cpp).
    const double tolerance = id == 7 ? 3e-4 : kRounding;
    ASSERT_EQ(pose.joints.size(), expected.joints.size());
    for (std::size_t j = 0; j < pose.joints.size(); ++j) {
      EXPECT_NEAR(pose.joints[j].u, expected.joints[j].u, tolerance);
      EXPECT_NEAR(pose.joints[j].v, expected.joints[j].v, tolerance);
      EXPECT_NEAR(pose.joints[j].d, expected.joints[j].d, tolerance);
    }
    ASSERT_EQ(pose.confidence.size(), expected.confidence.size());
    for (std::size_t j = 0; j < pose.confidence.size(); ++j) {
      EXPECT_NEAR(pose.confidence[j], expected.confidence[j], 10 * tolerance);
    }
    ASSERT_EQ(pose.right_hand.has_value(), expected.right_hand.has_value());
    EXPECT_NEAR(pose.right_hand.value_or(0.0), expected.right_hand.value_or(0.0), tolerance);
    ASSERT_EQ(pose.hand.has_value(), expected.hand.has_value());
    EXPECT_NEAR(pose.hand.value_or(0.0), expected.hand.value_or(0.0), tolerance);
  }
}

TEST_P(EveryArchitecture, SaysOfItselfWhatOurOwnDoes) {
  const NetworkEstimator own(PoseNetwork(*weights_), {});
  EXPECT_EQ(estimator_->convention().name, own.convention().name);
  EXPECT_EQ(estimator_->patches().options(), own.patches().options());
  EXPECT_EQ(estimator_->passes(), own.passes());
  EXPECT_EQ(estimator_->sure_confidence(), own.sure_confidence());
}

TEST_P(EveryArchitecture, KeepsWeightsAndOptions) {
  const OnnxModel model = load_onnx(folder_ / "net.onnx");
  const auto options = exported_options(model, "net.onnx");
  ASSERT_TRUE(options);
  EXPECT_EQ(network_options_as_toml(*options), network_options_as_toml(weights_->options()));
  EXPECT_EQ(model.opset, 13);
  // All numbers of the file are there, and none is rounded.
  std::vector<float> exported;
  for (const auto& [name, tensor] : model.constants) {
    exported.insert(exported.end(), tensor.reals.begin(), tensor.reals.end());
  }
  std::ranges::sort(exported);
  for (const NetworkArray& array : weights_->arrays()) {
    std::vector<float> numbers;
    if (array.precision == NetworkArray::Precision::half) {
      numbers = weights_->floats(array.name);
    } else {
      const auto singles = weights_->singles(array.name);
      numbers.assign(singles.begin(), singles.end());
    }
    for (const float number : numbers) {
      ASSERT_TRUE(std::ranges::binary_search(exported, number)) << array.name;
    }
  }
}

void expect_the_same_maps(const DetectorOptions& options) {
  const DetectorWeights weights = random_detector(options, 3);
  const HandDetector detector(weights);
  DetectorInput input{Image<float>(options.width, options.height),
                      Image<float>(options.width, options.height)};
  Random random(4, 0);
  for (float& value : input.inverse_depth.pixels()) value = static_cast<float>(random.uniform(0.0, 3.0));
  for (float& value : input.measured_share.pixels()) value = static_cast<float>(random.uniform());
  std::vector<float> planes(input.inverse_depth.pixels().begin(), input.inverse_depth.pixels().end());
  planes.insert(planes.end(), input.measured_share.pixels().begin(), input.measured_share.pixels().end());
  if (options.relief) {
    planes.resize(planes.size() + kReliefInputs * input.inverse_depth.size());
    write_reliefs(options, input.inverse_depth.pixels(),
                  std::span(planes).subspan(kMeasuredInputs * input.inverse_depth.size()));
  }
  const DetectorMaps expected = detector.maps_of(input);
  const std::vector<float> maps = OnnxNetwork(onnx_of(weights), "detector.onnx").run(planes).front();
  const std::size_t cells = expected.values.size() / kDetectorMaps;
  ASSERT_EQ(maps.size(), expected.values.size());
  for (std::size_t cell = 0; cell < cells; ++cell) {
    for (std::size_t map = 0; map < kDetectorMaps; ++map) {
      EXPECT_NEAR(maps[map * cells + cell], expected.values[cell * kDetectorMaps + map], 1e-5);
    }
  }
}

TEST(Export, TheDetectorsMapsAreItsOwn) {
  if (!onnx_support().is_there) GTEST_SKIP() << onnx_support().text;
  DetectorOptions options = testing::small_detector();
  expect_the_same_maps(options);
  options.relief = true;
  expect_the_same_maps(options);
}

TEST(Export, TheSameNetworkMakesTheSameBytes) {
  const NetworkWeights weights = random_weights(options_of("dense"), 1);
  EXPECT_EQ(onnx_bytes(onnx_of(weights)), onnx_bytes(onnx_of(weights)));
}

TEST(Export, TheNamesOfTheLandmarksGoWithIt) {
  NetworkOptions options = options_of("dense");
  options.convention = "nyu14";
  const std::string names = onnx_of(random_weights(options, 1)).metadata.at("knuckle.landmarks");
  EXPECT_EQ(std::ranges::count(names, ','), 13);
  EXPECT_THAT(names,
              ::testing::AllOf(::testing::StartsWith("little_tip, "), ::testing::HasSubstr(", thumb_tip, ")));
}

TEST(Export, WhatIsNoNetworkIsSaid) {
  const testing::TemporaryFolder folder;
  const auto fault = [&](const std::filesystem::path& model) {
    return error_of([&] { (void)export_network(model, folder / "out.onnx"); });
  };
  EXPECT_THAT(fault(testing::project_folder() / "models/pose_forest.model"),
              ::testing::AllOf(HasSubstr("pose_forest.model"), HasSubstr("knuckle-forest"),
                               HasSubstr("knuckle-network")));
  EXPECT_THAT(fault(folder / "none.pt"), HasSubstr("none.pt"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out.onnx"));
}

TEST(Export, TheNetworkItselfIsNotOverwritten) {
  const testing::TemporaryFolder folder;
  const std::filesystem::path model = folder / "net.pt";
  std::filesystem::copy_file(testing::project_folder() / "models/detector.pt", model);
  const std::string before = read_regular_file(model, std::int64_t{1} << 30);
  std::filesystem::create_symlink(model, folder / "link.onnx");
  for (const char* const out : {"net.pt", "link.onnx"}) {
    EXPECT_THAT(error_of([&] { (void)export_network(model, folder / out); }),
                HasSubstr("is the network itself; name another file"));
  }
  EXPECT_EQ(read_regular_file(model, std::int64_t{1} << 30), before);
}

TEST(Export, MetadataOfAnotherKindAreRefused) {
  OnnxModel model = onnx_of(random_detector(testing::small_detector(), 3));
  EXPECT_THAT(error_of([&] { (void)exported_options(model, "d.onnx"); }),
              ::testing::AllOf(HasSubstr("d.onnx"), HasSubstr("knuckle-detector")));
  model.metadata = {{"knuckle.kind", "knuckle-network"}};
  EXPECT_THAT(error_of([&] { (void)exported_options(model, "d.onnx"); }), HasSubstr("no knuckle.options"));
  model.metadata["knuckle.options"] = "[network]\narchitecture = 'abacus'";
  EXPECT_THAT(error_of([&] { (void)exported_options(model, "d.onnx"); }), HasSubstr("abacus"));
  model.metadata.clear();
  EXPECT_FALSE(exported_options(model, "d.onnx"));
}

}  // namespace
}  // namespace knuckle
