// SPDX-License-Identifier: Apache-2.0
// What a pipeline file says must be what its model was trained on.
#include <array>
#include <memory>

#include "knuckle/core/testing.h"
#include "knuckle/net/net_testing.h"
#include "knuckle/net/network_file.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class PipelineFile : public ::testing::Test {
 protected:
  PipelineFile() { save_network_weights(folder_ / "small.pt", random_weights(testing::small_network(), 1)); }

  Pipeline load(const std::string& toml) const {
    write_text_file(folder_ / "p.toml", toml + "[estimator]\nmethod = 'dense'\nmodel = 'small.pt'\n");
    return Pipeline::load(folder_ / "p.toml");
  }
  std::string fault(const std::string& toml) const {
    return testing::error_of([&] { load(toml); });
  }

  testing::TemporaryFolder folder_;
};

TEST_F(PipelineFile, SaysOfPatchesWhatTheModelWasTrainedOn) {
  EXPECT_EQ(load("").convention().name, "nyu14");
  EXPECT_EQ(load("[patch]\nmode = 'cube'\nsize_px = 32\ncube_mm = 200.0\n").convention().name, "nyu14");
  EXPECT_THAT(fault("[patch]\ncube_mm = 250.0\n"),
              AllOf(HasSubstr("p.toml:2: patch.cube_mm"), HasSubstr("cubes of 200 mm")));
  EXPECT_THAT(fault("[patch]\nsize_px = 96\n"),
              AllOf(HasSubstr("p.toml:2: patch.size_px"), HasSubstr("patches of 32 px")));
  EXPECT_THAT(fault("[patch]\nmode = 'hand'\n"),
              AllOf(HasSubstr("p.toml:2: patch.mode"), HasSubstr("\"cube\"")));
}

TEST_F(PipelineFile, IsSureWhereTheEstimatorIsUnlessItSaysOtherwise) {
  EXPECT_EQ(load("").hand().sure_confidence, 0.45);
  EXPECT_EQ(load("[hand]\nsure_confidence = 0.2\n").hand().sure_confidence, 0.2);
}

TEST_F(PipelineFile, MayBeATextWhosePathsStartFromAFolder) {
  const std::string toml = "[estimator]\nmethod = 'dense'\nmodel = 'small.pt'\n";
  EXPECT_EQ(Pipeline::from_toml(toml, folder_.path()).resolved_options(), load("").resolved_options());
  EXPECT_THAT(testing::error_of([&] { Pipeline::from_toml(toml, folder_ / "elsewhere"); }),
              HasSubstr("elsewhere/small.pt"));
  EXPECT_THAT(testing::error_of([&] { Pipeline::from_toml("hands = 1\n" + toml, folder_.path()); }),
              HasSubstr("pipeline:1: hands: unknown key"));
}

/// Sees the palm in the middle of every patch, and is sure of it from a confidence of 0.31 on.
class PalmEstimator final : public Estimator {
 public:
  Convention convention() const override { return {"palm1", kPalm}; }
  const PatchExtractor& patches() const override { return patches_; }
  double sure_confidence() const override { return 0.31; }
  PatchPose estimate(const HandPatch& /*patch*/) const override { return {{{0.0, 0.0, 0.0}}, {0.5f}}; }

 private:
  static constexpr std::array kPalm = {Landmark::palm};
  PatchExtractor patches_{{.size_px = 48, .mode = "cube", .cube_mm = 180.0}};
};

TEST_F(PipelineFile, AnEstimatorOfOnesOwnTakesThePlaceOfItsTable) {
  const std::string table = "[estimator]\nmethod = 'nobody knows it'\n[patch]\nsize_px = 32\n";
  const Pipeline pipeline = Pipeline::from_toml("[hand]\nmax_hands = 2\n" + table, folder_.path(),
                                                std::make_unique<PalmEstimator>());
  EXPECT_EQ(pipeline.convention().name, "palm1");
  EXPECT_EQ(pipeline.hand().max_hands, 2);
  EXPECT_EQ(pipeline.hand().sure_confidence, 0.31);
  EXPECT_THAT(pipeline.resolved_options(), Not(HasSubstr("[estimator]")));
  write_text_file(folder_ / "p.toml", table);
  EXPECT_EQ(Pipeline::load(folder_ / "p.toml", std::make_unique<PalmEstimator>()).convention().name, "palm1");
  EXPECT_THAT(testing::error_of([&] {
                Pipeline::from_toml("[hands]\nmax = 2\n", folder_.path(), std::make_unique<PalmEstimator>());
              }),
              HasSubstr("unknown key"));
}

TEST_F(PipelineFile, NumbersOfHandsHaveRanges) {
  const auto made = [&](const std::string& text) {
    return Pipeline::from_toml("[hand]\n" + text, folder_.path(), std::make_unique<PalmEstimator>());
  };
  for (const char* const text :
       {"max_hands = 1", "max_hands = 16", "candidates = 1", "candidates = 16", "sure_confidence = 0",
        "sure_confidence = 1", "hand_weight = 1", "judged_below = 1"}) {
    EXPECT_NO_THROW(made(text)) << text;
  }
  for (const char* const text :
       {"max_hands = 0", "max_hands = 17", "candidates = 0", "candidates = 17", "sure_confidence = -0.1",
        "sure_confidence = 1.1", "hand_weight = 1.1", "judged_below = 1.1"}) {
    const std::string key(text, std::string_view(text).find(' '));
    EXPECT_THAT(testing::error_of([&] { made(text); }), AllOf(HasSubstr(key), HasSubstr("expected"))) << text;
  }
}

}  // namespace
}  // namespace knuckle
