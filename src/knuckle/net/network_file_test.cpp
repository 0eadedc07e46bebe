// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/network_file.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file_testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::small_network;
using testing::write_network;
using testing::write_zip;
using testing::ZipRecords;

class NetworkFile : public ::testing::Test {
 protected:
  std::string fault() const {
    const std::string message = error_of([&] { load_network_weights(file_); });
    EXPECT_THAT(message, AllOf(HasSubstr("file.pt"), Not(HasSubstr("\n"))));
    return message;
  }
  /// The fault of a file with these records.
  std::string fault_of(const ZipRecords& records) const {
    write_zip(file_, records);
    return fault();
  }
  std::string fault_with_header(const std::string& header) const {
    ZipRecords records = testing::network_records(weights_);
    records[1].second = header;
    return fault_of(records);
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "file.pt";
  NetworkWeights weights_ = random_weights(small_network(), 1);
  std::string header_ = network_header(small_network());
};

TEST_F(NetworkFile, ComesBackAsItWas) {
  for (const std::string_view architecture : network_architectures()) {
    NetworkOptions options = small_network();
    options.architecture = architecture;
    NetworkWeights weights = random_weights(options, 2);
    for (float& number : weights.singles()) number += 1e-30f;
    write_network(file_, weights);
    const NetworkWeights read = load_network_weights(file_);
    EXPECT_EQ(network_options_as_toml(read.options()), network_options_as_toml(options));
    EXPECT_TRUE(std::ranges::equal(read.halves(), weights.halves()));
    EXPECT_TRUE(std::ranges::equal(read.singles(), weights.singles()));
  }
}

TEST_F(NetworkFile, TheOrderOfRecordsIsThatOfTheirNumbers) {
  ZipRecords records = testing::network_records(weights_);
  std::ranges::reverse(records);
  records.emplace_back("net/code/data/readme", "no tensor");
  records.emplace_back("net/data/", "");
  write_zip(file_, records);
  EXPECT_TRUE(std::ranges::equal(load_network_weights(file_).halves(), weights_.halves()));
}

TEST_F(NetworkFile, ThatIsMissingCutShortOrNone) {
  write_network(file_, weights_);
  const std::string bytes = read_text_file(file_);
  for (const double part : {0.0, 0.001, 0.3, 0.9, 0.999}) {
    write_text_file(file_,
                    bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
    EXPECT_THAT(fault(), HasSubstr("cut short")) << part;
  }
  write_text_file(file_, "a text\n");
  EXPECT_THAT(fault(), HasSubstr("no LibTorch archive"));
  std::filesystem::remove(file_);
  EXPECT_THAT(fault(), HasSubstr("no such file"));
  std::filesystem::create_directory(file_);
  EXPECT_THAT(fault(), HasSubstr("no such file"));
}

TEST_F(NetworkFile, WithAByteThatWasChanged) {
  write_network(file_, weights_);
  std::string bytes = read_text_file(file_);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_text_file(file_, bytes);
  EXPECT_THAT(fault(), HasSubstr("damaged"));
}

TEST_F(NetworkFile, OfAnotherKind) {
  EXPECT_THAT(fault_of({{"letters/a.txt", "a"}}), HasSubstr("no LibTorch archive"));
  EXPECT_THAT(fault_of({{"other/data.pkl", "weights"}, {"other/data/0", "1234"}}),
              HasSubstr("a LibTorch archive, but none of the format knuckle-network"));
  EXPECT_THAT(fault_of({{"old/data.pkl", "format X knuckle-network"}, {"old/data/0", "1234"}}),
              AllOf(HasSubstr("version 1"), HasSubstr("train it anew")));
  EXPECT_THAT(fault_of({{"old/data.pkl", "format X knuckle-network-checkpoint"}}), HasSubstr("checkpoint"));
}

TEST_F(NetworkFile, WithAWrongHeader) {
  EXPECT_THAT(fault_with_header("knuckle-network\n"), HasSubstr("no version"));
  EXPECT_THAT(fault_with_header("knuckle-network\nversion 2"), HasSubstr("no version"));
  EXPECT_THAT(fault_with_header("knuckle-network\nversion 99\n"), HasSubstr("version 99"));
  EXPECT_THAT(fault_with_header("knuckle-network\nversion 2\n"), HasSubstr("options is missing"));
  EXPECT_THAT(fault_with_header("knuckle-network\nversion 2\noptions\n[network]\narchitecture = 'magic'\n"),
              AllOf(HasSubstr("file.pt:2"), HasSubstr("magic")));
  NetworkOptions other = small_network();
  other.dense.head_channels = 48;
  std::string mixed = header_.substr(0, header_.find("options\n")) + "options\n";
  EXPECT_THAT(fault_with_header(mixed + network_options_as_toml(other)), HasSubstr("another shape"));
}

TEST_F(NetworkFile, WhoseTensorsDoNotFitItsOptions) {
  NetworkOptions other = small_network();
  other.dense.head_channels = 48;
  EXPECT_THAT(fault_with_header(network_header(other)), HasSubstr("bytes, expected"));
  NetworkOptions huge = small_network();
  huge.architecture = "regression";
  huge.paper = {.first_maps = 1024, .second_maps = 1024, .hidden_units = 65536};
  EXPECT_THAT(fault_with_header(network_header(huge)), HasSubstr("bytes, expected"))
      << "before there is room for so many";
  ZipRecords records = testing::network_records(weights_);
  records.pop_back();
  EXPECT_THAT(fault_of(records), HasSubstr("bytes, expected"));
}

TEST_F(NetworkFile, WithANumberThatIsNotFiniteOrAVarianceBelowZero) {
  NetworkWeights weights = weights_;
  weights.halves("stem.convolution.weight")[3] = half_of_float(1e30f);
  write_network(file_, weights);
  EXPECT_THAT(fault(), AllOf(HasSubstr("stem.convolution.weight"), HasSubstr("not finite")));
  weights = weights_;
  weights.singles("down1.norm.running_mean")[0] = std::nanf("");
  write_network(file_, weights);
  EXPECT_THAT(fault(), AllOf(HasSubstr("down1.norm.running_mean"), HasSubstr("not finite")));
  weights = weights_;
  weights.singles("down1.norm.running_var")[0] = -1.0f;
  write_network(file_, weights);
  EXPECT_THAT(fault(), AllOf(HasSubstr("down1.norm.running_var"), HasSubstr("negative")));
}

}  // namespace
}  // namespace knuckle
