// SPDX-License-Identifier: Apache-2.0
// The errors that the authors of published methods state, recomputed from their published predictions.
#include <ctime>
#include <ostream>

#include "knuckle/core/testing.h"
#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/eval/metrics/score_files.h"

namespace knuckle {
namespace {

struct PublishedMethod {
  std::string name;
  std::string file;
  double mean_3d_mm;
};

struct PublishedSet {
  std::string folder;
  std::string convention;
  std::string camera;
  std::int64_t frames;
  std::vector<PublishedMethod> methods;
};

/// How GoogleTest shows a parameter.
std::ostream& operator<<(std::ostream& stream, const PublishedSet& set) {
  return stream << set.folder;
}

class PublishedResults : public ::testing::TestWithParam<PublishedSet> {};

Evaluation evaluate_set(const PublishedSet& set, const std::filesystem::path& folder) {
  const Convention convention = convention_from_name(set.convention);
  const Truth truth = truth_from_file(folder / (set.folder + "_test_groundtruth_label.txt"), convention,
                                      camera_from_text(set.camera));
  std::vector<NamedPath> files;
  for (const PublishedMethod& method : set.methods) files.push_back({method.name, folder / method.file});
  return evaluate(truth, predictions_from_files(files, convention));
}

TEST_P(PublishedResults, ErrorsAreThosePublished) {
  KNUCKLE_REQUIRE_SHARED_DATA(shared);
  const PublishedSet& set = GetParam();
  const std::clock_t start = std::clock();  // of all threads: no less than the wall's on a quiet machine
  const Evaluation evaluation = evaluate_set(set, shared / "eval" / set.folder);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  RecordProperty("seconds", std::to_string(seconds));
  for (std::size_t i = 0; i < set.methods.size(); ++i) {
    EXPECT_NEAR(evaluation.methods[i].mean_3d_mm, set.methods[i].mean_3d_mm, 0.001) << set.methods[i].name;
    EXPECT_EQ(evaluation.methods[i].frames, set.frames);
    EXPECT_EQ(evaluation.methods[i].missing, 0);
  }
#ifdef NDEBUG
  EXPECT_LT(seconds, 2.0);
#endif
}

INSTANTIATE_TEST_SUITE_P(
    Sets, PublishedResults,
    ::testing::Values(PublishedSet{"nyu",
                                   "nyu14",
                                   "588.03,-587.07,320,240",
                                   8252,
                                   {{"DeepPrior++", "ICCVW17_NYU_DeepPrior++.txt", 12.238},
                                    {"Pose_REN", "NEUCOM18_NYU_Pose_REN.txt", 11.811},
                                    {"CrossInfoNet", "CVPR19_NYU_CrossInfoNet.txt", 10.078},
                                    {"V2V", "CVPR18_NYU_V2V_PoseNet.txt", 8.419}}},
                      PublishedSet{"icvl",
                                   "icvl16",
                                   "240.99,240.96,160,120",
                                   1596,
                                   {{"LRF", "CVPR14_LRF_Results.txt", 12.578},
                                    {"Pose_REN", "NEUCOM18_ICVL_Pose_REN.txt", 6.791},
                                    {"CrossInfoNet", "CVPR19_ICVL_CrossInfoNet.txt", 6.732},
                                    {"V2V", "CVPR18_ICVL_V2V_PoseNet.txt", 6.284}}}),
    [](const auto& instance) { return instance.param.folder; });

}  // namespace
}  // namespace knuckle
