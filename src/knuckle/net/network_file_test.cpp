// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::small_network;

class NetworkFile : public ::testing::Test {
 protected:
  std::string fault() const {
    const std::string message = error_of([&] { load_network_weights(file_); });
    EXPECT_THAT(message, AllOf(HasSubstr("file.pt"), Not(HasSubstr("\n"))));
    return message;
  }
  /// The fault of a sound network's file but for one change.
  std::string fault_with(const std::function<void(ModelWriter&)>& change) const {
    save_network_weights(file_, weights_);
    testing::change_model(file_, change);
    return fault();
  }
  std::string fault_with_options(const std::string& toml) const {
    return fault_with([&](ModelWriter& model) { model.set("options", toml); });
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "file.pt";
  NetworkWeights weights_ = random_weights(small_network(), 1);
};

TEST_F(NetworkFile, ComesBackAsItWas) {
  for (const std::string_view architecture : network_architectures()) {
    NetworkOptions options = small_network();
    options.architecture = architecture;
    NetworkWeights weights = random_weights(options, 2);
    for (float& number : weights.singles()) number += 1e-30f;
    save_network_weights(file_, weights);
    const NetworkWeights read = load_network_weights(file_);
    EXPECT_EQ(network_options_as_toml(read.options()), network_options_as_toml(options));
    EXPECT_TRUE(std::ranges::equal(read.halves(), weights.halves()));
    EXPECT_TRUE(std::ranges::equal(read.singles(), weights.singles()));
  }
}

TEST_F(NetworkFile, ThatIsMissingCutShortOrNone) {
  save_network_weights(file_, weights_);
  const std::string bytes = read_text_file(file_);
  for (const double part : {0.0, 0.001, 0.3, 0.9, 0.999}) {
    write_text_file(file_,
                    bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
    EXPECT_THAT(fault(), HasSubstr("cut short")) << part;
  }
  write_text_file(file_, "a text\n");
  EXPECT_THAT(fault(), HasSubstr("not a model's file"));
  std::filesystem::remove(file_);
  EXPECT_THAT(fault(), HasSubstr("No such file"));
  std::filesystem::create_directory(file_);
  EXPECT_THAT(fault(), HasSubstr("found a folder"));
}

TEST_F(NetworkFile, WithAByteThatWasChanged) {
  save_network_weights(file_, weights_);
  std::string bytes = read_text_file(file_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_text_file(file_, bytes);
  EXPECT_THAT(fault(), HasSubstr("damaged"));
}

TEST_F(NetworkFile, OfAnotherKindOrVersion) {
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.set_format("knuckle-forest", 2); }),
              HasSubstr("expected a knuckle-network file, found a knuckle-forest file"));
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.set_format("knuckle-network", 99); }),
              HasSubstr("version 99 of the format knuckle-network, expected version 3"));
  write_text_file(file_, std::string("PK\x03\x04") + "net/data.pkl knuckle-network");
  EXPECT_THAT(fault(), AllOf(HasSubstr("an archive of LibTorch"), HasSubstr("0.1"), HasSubstr("train")));
}

TEST_F(NetworkFile, WithWrongOptions) {
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.remove("options"); }),
              HasSubstr("options is missing"));
  EXPECT_THAT(fault_with_options("[network]\narchitecture = 'magic'\n"),
              AllOf(HasSubstr("file.pt:2"), HasSubstr("magic")));
}

TEST_F(NetworkFile, WhoseArraysDoNotFitItsOptions) {
  NetworkOptions other = small_network();
  other.dense.head_channels = 48;
  EXPECT_THAT(fault_with_options(network_options_as_toml(other)), HasSubstr("that its options ask for"));
  NetworkOptions huge = small_network();
  huge.architecture = "regression";
  huge.paper = {.first_maps = 1024, .second_maps = 1024, .hidden_units = 65536};
  EXPECT_THAT(fault_with_options(network_options_as_toml(huge)), HasSubstr("that its options ask for"))
      << "before there is room for so many";
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.remove("norms"); }),
              HasSubstr("norms: the array is missing"));
  EXPECT_THAT(fault_with([](ModelWriter& model) {
                model.add("weights", {2}, std::vector<float>{1, 2});
              }),
              HasSubstr("weights has 2 numbers"));
}

TEST_F(NetworkFile, WithANumberThatIsNotFiniteOrAVarianceBelowZero) {
  NetworkWeights weights = weights_;
  weights.halves("stem.convolution.weight")[3] = half_of_float(1e30f);
  save_network_weights(file_, weights);
  EXPECT_THAT(fault(), AllOf(HasSubstr("stem.convolution.weight"), HasSubstr("not finite")));
  weights = weights_;
  weights.singles("down1.norm.running_mean")[0] = std::nanf("");
  save_network_weights(file_, weights);
  EXPECT_THAT(fault(), AllOf(HasSubstr("down1.norm.running_mean"), HasSubstr("not finite")));
  weights = weights_;
  weights.singles("down1.norm.running_var")[0] = -1.0f;
  save_network_weights(file_, weights);
  EXPECT_THAT(fault(), AllOf(HasSubstr("down1.norm.running_var"), HasSubstr("negative")));
}

}  // namespace
}  // namespace knuckle
