// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/trainers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/open_source.h"
#include "knuckle/pipeline/pose_forest_training.h"
#include "knuckle/pipeline/segmentation_forest_training.h"
#include "knuckle/segment/segmentation_forest.h"

namespace knuckle {
namespace {

/// One kind of training.
struct Trainer {
  std::string_view kind;
  std::string (*source)(const std::filesystem::path& config);
  void (*train)(const std::filesystem::path& config, double scale, const std::filesystem::path& out);
};

template <class Config>
std::string source_of(const std::filesystem::path& config) {
  return Config::load(config).source;
}

template <class Config>
Config scaled_config(const std::filesystem::path& path, double scale) {
  Config config = Config::load(path);
  config.source = scaled_source(config.source, scale);
  return config;
}

std::filesystem::path checkpoint_beside(const std::filesystem::path& out) {
  return out.string() + ".checkpoint";
}

void train_pose_forest_model(const std::filesystem::path& path, double scale,
                             const std::filesystem::path& out) {
  const auto config = scaled_config<PoseForestTrainingConfig>(path, scale);
  save_pose_forest(out, run_training(config, checkpoint_beside(out)).model);
}

void train_segmentation_forest_model(const std::filesystem::path& path, double scale,
                                     const std::filesystem::path& out) {
  const auto config = scaled_config<SegmentationForestTrainingConfig>(path, scale);
  save_segmentation_forest(out,
                           run_training(config, TrainingRun{.checkpoint = checkpoint_beside(out)}).forest);
}

constexpr std::array kTrainers{
    Trainer{"pose-forest", source_of<PoseForestTrainingConfig>, train_pose_forest_model},
    Trainer{"segmentation-forest", source_of<SegmentationForestTrainingConfig>,
            train_segmentation_forest_model},
};

const Trainer& trainer_of(std::string_view kind) {
  const auto* trainer = std::ranges::find(kTrainers, kind, &Trainer::kind);
  if (trainer != kTrainers.end()) return *trainer;
  std::vector<std::string> known;
  for (const Trainer& each : kTrainers) known.emplace_back(each.kind);
  fail("no training of the kind '{}'; known: {}", kind, joined(known));
}

}  // namespace

std::string training_source(std::string_view kind, const std::filesystem::path& config) {
  return trainer_of(kind).source(config);
}

void train_model(std::string_view kind, const std::filesystem::path& config, double scale,
                 const std::filesystem::path& out) {
  trainer_of(kind).train(config, scale, out);
}

std::string scaled_source(const std::string& source, double scale) {
  if (scale == 1.0) return source;
  const auto frames = static_cast<double>(open_source(source)->size());
  const auto count = std::max<std::int64_t>(1, std::llround(frames * scale));
  const std::vector<std::string_view> parts = split(source, '?');
  std::string scaled = fmt::format("{}?count={}", parts.front(), count);
  if (parts.size() == 1) return scaled;
  for (const std::string_view setting : split(parts[1], '&')) {
    if (!setting.starts_with("count=")) scaled += fmt::format("&{}", setting);
  }
  return scaled;
}

}  // namespace knuckle
