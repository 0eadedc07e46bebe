// SPDX-License-Identifier: Apache-2.0
#include "knuckle/estimate/pose_forest.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/storage/model_file.h"

namespace knuckle {

namespace {

constexpr std::string_view kFormat = "knuckle-forest";
constexpr int kVersion = 2;
constexpr std::string_view kKind = "pose";
/// Spread of the trees at which the confidence falls to 1 / e, in patch coordinates.
constexpr float kAgreementScale = 0.1F;

/// Looks at every value, without a branch, so that the loop vectorises.
bool all_finite(std::span<const float> values) {
  int faults = 0;
  for (const float value : values) faults |= std::abs(value) <= std::numeric_limits<float>::max() ? 0 : 1;
  return faults == 0;
}

/// Throws where the parts of a model do not belong together.
void check(const PoseForestModel& model, const std::string& origin) {
  const int size = model.statistics.size_px;
  if (size < 2 || model.forest.feature_count() != size * size) {
    fail("{}: the forest reads {} pixels, expected those of a patch of {} x {}", origin,
         model.forest.feature_count(), size, size);
  }
  const std::size_t landmarks = model.convention.landmarks.size();
  if (model.forest.target_count() != static_cast<int>(landmarks) * kTargetsPerLandmark) {
    fail("{}: the forest predicts {} numbers, expected u v d of the {} landmarks of {}", origin,
         model.forest.target_count(), landmarks, model.convention.name);
  }
  const Image<float>& mean = model.statistics.mean;
  if (!mean.empty() && (mean.width() != size || mean.height() != size)) {
    fail("{}: the mean patch is {} x {}, expected {} x {}", origin, mean.width(), mean.height(), size, size);
  }
  if (!all_finite(mean.pixels())) fail("{}: a pixel of the mean patch is not finite", origin);
  if (!model.statistics.whitening.empty()) fail("{}: a pose forest takes no whitening", origin);
}

PoseForestModel checked(PoseForestModel model) {
  check(model, "pose forest");
  return model;
}

PatchStatistics read_statistics(const ModelFile& file) {
  PatchStatistics statistics;
  statistics.size_px = file.integer("patch_size_px", 0, limits::kImageSide);
  if (!file.has("patch_mean")) return statistics;
  const ModelArray<float> mean = file.read<float>("patch_mean");
  const auto size = static_cast<std::uint64_t>(statistics.size_px);
  if (mean.shape != std::vector<std::uint64_t>{size, size}) {
    fail("{}: patch_mean has {} values, expected {} x {}", file.origin(), mean.values.size(), size, size);
  }
  statistics.mean = Image<float>(statistics.size_px, statistics.size_px);
  std::ranges::copy(mean.values, statistics.mean.pixels().begin());
  return statistics;
}

Convention read_convention(const ModelFile& file) {
  try {
    return convention_from_text(file.text("convention"));
  } catch (const Error& error) {
    fail("{}: {}", file.origin(), error.what());
  }
}

}  // namespace

namespace {

/// What a unit of each target counts.
std::vector<float> target_scale(const PoseForestModel& model) {
  std::vector<float> scale;
  for (std::size_t i = 0; i < model.convention.landmarks.size(); ++i) {
    scale.insert(scale.end(), {1.0F, 1.0F, static_cast<float>(kDepthWeight)});
  }
  return scale;
}

void save(const std::filesystem::path& path, const PoseForestModel& model,
          const std::optional<LeafCoding>& coding) {
  check(model, path.string());
  ModelWriter file(kFormat, kVersion);
  file.set("kind", kKind);
  file.set("convention", convention_text(model.convention));
  file.set("patch_size_px", model.statistics.size_px);
  if (const Image<float>& mean = model.statistics.mean; !mean.empty()) {
    const auto size = static_cast<std::uint64_t>(model.statistics.size_px);
    file.add<float>("patch_mean", {size, size}, mean.pixels());
  }
  write_forest(file, model.forest, coding);
  file.save(path);
}

}  // namespace

void save_pose_forest(const std::filesystem::path& path, const PoseForestModel& model) {
  save(path, model, std::nullopt);
}

void save_pose_forest(const std::filesystem::path& path, const PoseForestModel& model, float leaf_step) {
  save(path, model, LeafCoding{leaf_step, target_scale(model)});
}

PoseForestModel load_pose_forest(const std::filesystem::path& path) {
  return read_pose_forest(ModelFile::open(path));
}

PoseForestModel read_pose_forest(const ModelFile& file) {
  file.require_format(kFormat, kVersion);
  const std::string kind = file.text("kind");
  if (kind != kKind) fail("{}: a forest of kind \"{}\", expected \"{}\"", file.origin(), kind, kKind);
  PoseForestModel model{read_convention(file), read_statistics(file), read_forest(file)};
  check(model, file.origin());
  return model;
}

PoseForestModel pruned(const PoseForestModel& model, std::size_t most_leaves) {
  return {model.convention, model.statistics, model.forest.pruned(most_leaves, target_scale(model))};
}

PoseForestEstimator::PoseForestEstimator(PoseForestModel model)
    : model_(checked(std::move(model))),
      patches_({.size_px = model_.statistics.size_px}, model_.statistics) {}

PatchPose PoseForestEstimator::estimate(const HandPatch& patch) const {
  const int size = model_.statistics.size_px;
  if (patch.pixels.width() != size || patch.pixels.height() != size) {
    fail("pose forest: a patch of {} x {}, expected {} x {}", patch.pixels.width(), patch.pixels.height(),
         size, size);
  }
  if (!all_finite(patch.pixels.pixels())) fail("pose forest: a pixel of the patch is not finite");

  const RegressionForest::Prediction prediction = model_.forest.predict(patch.pixels.pixels());
  PatchPose pose;
  for (std::size_t i = 0; i < prediction.mean.size(); i += kTargetsPerLandmark) {
    pose.joints.push_back({prediction.mean[i], prediction.mean[i + 1], prediction.mean[i + 2]});
    if (model_.forest.tree_count() > 1) {
      const float spread = std::hypot(prediction.deviation[i], prediction.deviation[i + 1]) / std::sqrt(2.0F);
      pose.confidence.push_back(std::exp(-spread / kAgreementScale));
    }
  }
  return pose;
}

}  // namespace knuckle
