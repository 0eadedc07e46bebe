// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/create_estimator.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/estimate/estimate_testing.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;

class CreateEstimator : public ::testing::Test {
 protected:
  CreateEstimator() {
    std::filesystem::create_directory(folder_ / "models");
    save_pose_forest(folder_ / "models" / "small.model",
                     testing::made_up_model(convention_from_name("nyu14")));
  }

  std::unique_ptr<Estimator> create(const std::string& toml) const {
    write_text_file(folder_ / "p.toml", toml);
    return create_estimator(OptionTable::load(folder_ / "p.toml"));
  }

  std::string fault(const std::string& toml) const {
    return error_of([&] { create(toml); });
  }

  TemporaryFolder folder_;
};

const std::string kForest = "method = \"forest\"\nmodel = \"models/small.model\"\n";

TEST_F(CreateEstimator, FindsTheModelBesideTheFile) {
  EXPECT_EQ(create(kForest)->convention().name, "nyu14");
  EXPECT_EQ(create(kForest + "convention = \"nyu14\"\npatch_size_px = 12")->patches().options().size_px, 12);
  EXPECT_NE(std::ranges::find(estimator_names(), "forest"), estimator_names().end());
}

TEST_F(CreateEstimator, NamesWhatIsWrong) {
  EXPECT_THAT(fault("model = \"models/small.model\""), AllOf(HasSubstr("p.toml"), HasSubstr("method")));
  EXPECT_THAT(fault("method = \"forest\""), AllOf(HasSubstr("p.toml"), HasSubstr("model")));
  EXPECT_THAT(fault("method = \"oracle\"\nmodel = \"x\""),
              AllOf(HasSubstr("p.toml"), HasSubstr("oracle"), HasSubstr("forest")));
  EXPECT_THAT(fault("method = \"forest\"\nmodel = \"none.model\""), HasSubstr("none.model"));
  EXPECT_THAT(fault(kForest + "modle = \"x\""), AllOf(HasSubstr("p.toml"), HasSubstr("modle")));
  EXPECT_THAT(fault(kForest + "patch_size_px = 96"), AllOf(HasSubstr("p.toml:3"), HasSubstr("12 x 12")));
  EXPECT_THAT(fault(kForest + "convention = \"icg20\""), AllOf(HasSubstr("icg20"), HasSubstr("nyu14")));
}

}  // namespace
}  // namespace knuckle
