// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/check_model.h"

#include <string>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/estimate/pose_forest.h"
#include "knuckle/experiment/network_config.h"
#include "knuckle/net/pose_network.h"
#include "knuckle/prepare/pose_forest_training.h"
#include "knuckle/segment/segmentation_forest.h"

namespace knuckle {
namespace {

/// Compares what a model is with what its configuration asks for.
class ModelCheck {
 public:
  ModelCheck(const std::filesystem::path& model, const std::filesystem::path& config)
      : model_(model), config_(config) {}

  template <class Value>
  void expect(std::string_view what, const Value& found, const Value& wanted) const {
    if (found == wanted) return;
    fail("{}: its {} is {}, but {} asks for {}", model_.string(), what, found, config_.string(), wanted);
  }

 private:
  const std::filesystem::path& model_;
  const std::filesystem::path& config_;
};

void check_pose_forest(const std::filesystem::path& config_file, const std::filesystem::path& model) {
  const auto config = PoseForestTrainingConfig::load(config_file);
  const PoseForestModel forest = load_pose_forest(model);
  const ModelCheck check(model, config_file);
  check.expect("convention", std::string(forest.convention.name), std::string(config.convention.name));
  check.expect("patch size [px]", forest.statistics.size_px, config.patch.size_px);
}

void check_network(const std::filesystem::path& config_file, const std::filesystem::path& model) {
  const NetworkOptions wanted = NetworkConfig::load(config_file).network;
  const NetworkOptions found = PoseNetwork(model).options();
  const ModelCheck check(model, config_file);
  check.expect("architecture", found.architecture, wanted.architecture);
  check.expect("convention", found.convention, wanted.convention);
  check.expect("patch size [px]", found.patch.size_px, wanted.patch.size_px);
  check.expect("cube [mm]", found.patch.cube_mm, wanted.patch.cube_mm);
}

}  // namespace

void check_model(std::string_view kind, const std::filesystem::path& config,
                 const std::filesystem::path& model) {
  if (kind == "network") {
    check_network(config, model);
  } else if (kind == "pose-forest") {
    check_pose_forest(config, model);
  } else {
    load_segmentation_forest(model);
  }
}

}  // namespace knuckle
