// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_options.h"

#include "knuckle/core/testing.h"
#include "knuckle/net/exported_network.h"
#include "knuckle/net/network_architectures.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

std::string fault(const NetworkOptions& options) {
  return error_of([&] { check(options, "net.toml"); });
}

TEST(NetworkOptions, AreTheSameAfterTomlAndBack) {
  for (const std::string_view architecture : network_architectures()) {
    NetworkOptions options;
    options.architecture = architecture;
    options.convention = "icg20";
    options.patch.size_px = 64;
    options.dense.blocks = 3;
    options.paper.hidden_units = 123;
    const std::string toml = network_options_as_toml(options);
    const NetworkOptions back = network_options_from_toml(toml, "net.pt");
    EXPECT_EQ(network_options_as_toml(back), toml);
    EXPECT_EQ(back.architecture, architecture);
    EXPECT_EQ(back.joint_count(), 20);
    EXPECT_EQ(back.patch, options.patch);
    EXPECT_EQ(architecture == "dense" ? back.dense.blocks : 3, 3);
    EXPECT_EQ(architecture == "dense" ? 123 : back.paper.hidden_units, 123);
  }
}

TEST(NetworkOptions, OfAnExportedNetworkAreInItsMetadata) {
  OnnxModel model;
  EXPECT_FALSE(exported_options(model, "net.onnx")) << "somebody else's";
  NetworkOptions options;
  options.patch.size_px = 64;
  set_exported_options(model, options);
  EXPECT_EQ(exported_options(model, "net.onnx")->patch.size_px, 64);
  const auto fault_of = [](const OnnxModel& changed) {
    return error_of([&] { (void)exported_options(changed, "net.onnx"); });
  };
  OnnxModel other = model;
  other.metadata["knuckle.kind"] = "knuckle-detector";
  EXPECT_THAT(fault_of(other),
              HasSubstr("net.onnx: it is a \"knuckle-detector\", expected a \"knuckle-network\""));
  model.metadata.erase("knuckle.options");
  EXPECT_THAT(fault_of(model), HasSubstr("net.onnx: its metadata have no knuckle.options"));
}

TEST(NetworkOptions, HoldAConventionOfOnesOwn) {
  NetworkOptions options;
  options.convention = "net_lab: wrist, net_lab_knob~index_mcp, little_tip";
  check(options, "net.toml");
  EXPECT_EQ(options.joint_count(), 3);
  EXPECT_EQ(options.landmarks().name, "net_lab");
  const NetworkOptions back = network_options_from_toml(network_options_as_toml(options), "net.pt");
  EXPECT_EQ(back.landmarks(), options.landmarks());
  options.convention = "net_other: wrist, toe";
  EXPECT_THAT(fault(options), HasSubstr("'toe' is no landmark"));
}

TEST(NetworkOptions, RefuseWhatDoesNotFitTogether) {
  NetworkOptions options;
  options.architecture = "wide";
  EXPECT_THAT(fault(options), AllOf(HasSubstr("net.toml"), HasSubstr("wide"), HasSubstr("dense")));
  EXPECT_THAT(error_of([&] { (void)architecture_of(options); }), HasSubstr("unknown network 'wide'"));
  options = {};
  options.convention = "toes";
  EXPECT_THAT(fault(options), HasSubstr("toes"));
  options = {};
  options.patch.size_px = 40;
  EXPECT_THAT(fault(options), AllOf(HasSubstr("size_px is 40"), HasSubstr("multiple of 16")));
  options.patch.size_px = 16;
  EXPECT_NO_THROW(check(options, "net.toml"));
  options.architecture = "regression";
  EXPECT_THAT(fault(options), AllOf(HasSubstr("at least 32"), HasSubstr("regression")));
  options = {};
  options.patch.mode = "hand";
  EXPECT_THAT(fault(options), HasSubstr("cube"));
}

TEST(NetworkOptions, RefuseNumbersOutOfRange) {
  NetworkOptions options;
  options.dense.stem_channels = 0;
  EXPECT_THAT(fault(options), HasSubstr("stem_channels"));
  options = {};
  options.dense.kernel = 0.0;
  EXPECT_THAT(fault(options), HasSubstr("kernel"));
  options = {};
  options.architecture = "pca";
  options.paper.dropout = 1.0;
  EXPECT_THAT(fault(options), HasSubstr("dropout"));
  options.paper = {.peak = "highest"};
  EXPECT_THAT(fault(options), HasSubstr("highest"));
}

TEST(NetworkOptions, RefuseMapsThatWouldTakeTheMachinesMemory) {
  NetworkOptions dense;
  dense.patch.size_px = 1024;
  EXPECT_NO_THROW(check(dense, "net.toml"));
  dense.dense.stem_channels = 1024;
  EXPECT_THAT(fault(dense), HasSubstr("features per patch"));
  NetworkOptions paper;
  paper.architecture = "regression";
  paper.patch.size_px = 512;
  paper.paper.first_maps = 100;
  paper.paper.second_maps = 100;
  EXPECT_NO_THROW(check(paper, "net.toml"));
  paper.paper.second_maps = 400;
  EXPECT_THAT(fault(paper), HasSubstr("a patch of 512 px and so many channels make 131072000 features"));
}

TEST(NetworkOptions, KnowOnlyTheKeysOfTheirArchitecture) {
  const auto read = [](const std::string& toml) {
    return error_of([&] { network_options_from_toml(toml, "net.pt"); });
  };
  EXPECT_THAT(read("[patch]\nmode = 'cube'\n[network]\narchitecture = 'regression'\nblocks = 2\n"),
              AllOf(HasSubstr("net.pt:5"), HasSubstr("blocks")));
  EXPECT_THAT(read("[network]\narchitecture = 'dense'\nhidden_units = 2\n"), HasSubstr("net.pt:3"));
}

}  // namespace
}  // namespace knuckle
