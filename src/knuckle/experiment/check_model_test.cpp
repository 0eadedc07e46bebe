// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/check_model.h"

#include "knuckle/core/resources.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CheckModelTest : public ::testing::Test {
 protected:
  /// The shipped configuration with one text replaced.
  std::filesystem::path changed(const std::string& config, const std::string& from,
                                const std::string& to) const {
    std::string text = read_text_file(resource_path(config));
    text.replace(text.find(from), from.size(), to);
    write_text_file(folder_ / "train.toml", text);
    return folder_ / "train.toml";
  }

  static std::string fault(const std::string& kind, const std::filesystem::path& config,
                           const std::filesystem::path& model) {
    return error_of([&] { check_model(kind, config, model); });
  }

  TemporaryFolder folder_;
  std::filesystem::path dense_ = resource_path("models/dense.pt");
  std::filesystem::path forest_ = resource_path("models/pose_forest.model");
};

TEST_F(CheckModelTest, TheShippedModelsAreWhatTheirConfigurationsMake) {
  EXPECT_NO_THROW(check_model("network", resource_path("pipelines/train_dense.toml"), dense_));
  EXPECT_NO_THROW(check_model("pose-forest", resource_path("pipelines/train_pose_forest.toml"), forest_));
}

TEST_F(CheckModelTest, NamesWhatDiffers) {
  EXPECT_THAT(
      fault("network", resource_path("pipelines/train_pca.toml"), dense_),
      AllOf(HasSubstr("dense.pt: its architecture is dense"), HasSubstr("train_pca.toml asks for pca")));
  EXPECT_THAT(fault("network", changed("pipelines/train_dense.toml", "knuckle22", "icg20"), dense_),
              AllOf(HasSubstr("its convention is knuckle22"), HasSubstr("asks for icg20")));
  EXPECT_THAT(
      fault("network", changed("pipelines/train_dense.toml", "size_px = 96", "size_px = 112"), dense_),
      AllOf(HasSubstr("its patch size [px] is 96"), HasSubstr("asks for 112")));
  EXPECT_THAT(
      fault("network", changed("pipelines/train_dense.toml", "cube_mm = 250", "cube_mm = 300"), dense_),
      HasSubstr("its cube [mm] is 250"));
  EXPECT_THAT(
      fault("pose-forest", changed("pipelines/train_pose_forest.toml", "\"icg20\"", "\"msra21\""), forest_),
      AllOf(HasSubstr("its convention is icg20"), HasSubstr("asks for msra21")));
  EXPECT_THAT(fault("pose-forest",
                    changed("pipelines/train_pose_forest.toml", "size_px = 96", "size_px = 64"), forest_),
              HasSubstr("its patch size [px] is 96"));
}

TEST_F(CheckModelTest, NamesAFileOfAnotherKind) {
  EXPECT_THAT(fault("network", resource_path("pipelines/train_dense.toml"), forest_),
              HasSubstr("pose_forest.model"));
  EXPECT_THAT(fault("pose-forest", resource_path("pipelines/train_pose_forest.toml"), dense_),
              HasSubstr("dense.pt"));
  EXPECT_THAT(
      fault("segmentation-forest", resource_path("pipelines/train_segmentation_forest.toml"), forest_),
      HasSubstr("pose_forest.model"));
  EXPECT_THAT(fault("network", resource_path("pipelines/train_dense.toml"), folder_ / "none.pt"),
              HasSubstr("none.pt"));
}

}  // namespace
}  // namespace knuckle::testing
