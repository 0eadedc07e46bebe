// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_file.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/segment/detector/detector_testing.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/model_testing.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::small_detector;

class DetectorFile : public ::testing::Test {
 protected:
  std::string fault() const {
    const std::string message = error_of([&] { load_detector_weights(file_); });
    EXPECT_THAT(message, AllOf(HasSubstr("hands.pt"), Not(HasSubstr("\n"))));
    return message;
  }
  /// The fault of a sound file but for one change.
  std::string fault_with(const std::function<void(ModelWriter&)>& change) const {
    save_detector_weights(file_, weights_);
    testing::change_model(file_, change);
    return fault();
  }
  std::string fault_with_options(const DetectorOptions& options) const {
    return fault_with([&](ModelWriter& model) { model.set("options", detector_options_as_toml(options)); });
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "hands.pt";
  DetectorWeights weights_ = random_detector(small_detector(), 1);
};

TEST_F(DetectorFile, ComesBackAsItWas) {
  save_detector_weights(file_, weights_);
  const DetectorWeights read = load_detector_weights(file_);
  EXPECT_EQ(detector_options_as_toml(read.options()), detector_options_as_toml(small_detector()));
  EXPECT_TRUE(std::ranges::equal(read.halves(), weights_.halves()));
  EXPECT_TRUE(std::ranges::equal(read.singles(), weights_.singles()));
}

TEST_F(DetectorFile, ThatIsMissingCutShortOrChanged) {
  EXPECT_THAT(fault(), HasSubstr("No such file"));
  save_detector_weights(file_, weights_);
  const std::string bytes = read_text_file(file_);
  for (const double part : {0.0, 0.01, 0.5, 0.999}) {
    write_text_file(file_,
                    bytes.substr(0, static_cast<std::size_t>(part * static_cast<double>(bytes.size()))));
    EXPECT_THAT(fault(), HasSubstr("cut short")) << part;
  }
  std::string changed = bytes;
  changed[changed.size() / 2] = static_cast<char>(changed[changed.size() / 2] ^ 1);
  write_text_file(file_, changed);
  EXPECT_THAT(fault(), HasSubstr("damaged"));
}

TEST_F(DetectorFile, OfAnotherKindVersionOrSize) {
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.set_format("knuckle-network", 3); }),
              HasSubstr("expected a knuckle-detector file, found a knuckle-network file"));
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.set_format("knuckle-detector", 7); }),
              HasSubstr("version 7"));
  EXPECT_THAT(fault_with([](ModelWriter& model) { model.remove("norms"); }), HasSubstr("norms"));
  DetectorOptions other = small_detector();
  other.head_channels = 24;
  EXPECT_THAT(fault_with_options(other), HasSubstr("that its options ask for"));
  other = small_detector();
  other.width = 72;
  EXPECT_THAT(fault_with_options(other), HasSubstr("expected multiples of 16"));
  other.width = 0;
  EXPECT_THAT(fault_with_options(other), HasSubstr("width"));
}

TEST_F(DetectorFile, WithANumberThatIsNotFinite) {
  weights_.halves("head.bias")[2] = half_of_float(1e30f);
  save_detector_weights(file_, weights_);
  EXPECT_THAT(fault(), AllOf(HasSubstr("head.bias"), HasSubstr("not finite")));
}

}  // namespace
}  // namespace knuckle
