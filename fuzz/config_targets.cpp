// SPDX-License-Identifier: Apache-2.0
// TOML files that say what the program does: pipelines, trainings, plans of experiments. Files that they name
// are looked for in a folder that is not there.
#include "fuzz_target.h"

#include <memory>
#include <stdexcept>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/experiment/network_config.h"
#include "knuckle/experiment/plan.h"
#include "knuckle/pipeline/pipeline.h"
#include "knuckle/prepare/pose_forest_training.h"
#include "knuckle/prepare/segmentation_forest_training.h"

namespace knuckle::fuzz {
namespace {

constexpr std::string_view kNowhere = "/proc/self/nowhere";

/// In place of a network, so that the other tables of a pipeline file are reached.
class SeesNothing final : public Estimator {
 public:
  Convention convention() const override { return superset_convention(); }
  const PatchExtractor& patches() const override { return patches_; }
  PatchPose estimate(const HandPatch& /*patch*/) const override {
    return {.joints = std::vector<PatchPoint>(superset_convention().landmarks.size()), .confidence = {}};
  }

 private:
  PatchExtractor patches_{PatchOptions{}};
};

}  // namespace

/// '0': with an estimator of the program's own; what it resolves to resolves to itself. '1': with that of the
/// file.
void run_pipeline(Bytes bytes) {
  const auto [which, content] = selected(bytes, 2);
  if (which == 1) {
    (void)Pipeline::from_toml(as_text(content), kNowhere);
    return;
  }
  const Pipeline pipeline = Pipeline::from_toml(as_text(content), kNowhere, std::make_unique<SeesNothing>());
  if (Pipeline::from_toml(pipeline.resolved_options(), kNowhere, std::make_unique<SeesNothing>())
          .resolved_options() != pipeline.resolved_options())
    throw std::logic_error("resolved options resolve to others");
}

/// '0': of a pose forest; '1': of a segmentation forest; '2': of a network, as far as an experiment reads it.
void run_training_config(Bytes bytes) {
  const auto [which, content] = selected(bytes, 3);
  const FuzzFile file(content, ".toml");
  if (which == 0) (void)PoseForestTrainingConfig::load(file.path());
  if (which == 1) (void)SegmentationForestTrainingConfig::load(file.path());
  if (which == 2) (void)NetworkConfig::load(file.path());
}

void run_plan(Bytes bytes) {
  const FuzzFile file(bytes, ".toml");
  for (const PlannedMethod& method : ExperimentPlan::load(file.path()).estimation) (void)method.stem();
}

}  // namespace knuckle::fuzz
