// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "knuckle/net/network_options.h"
#include "knuckle/training/sample_views.h"
#include "knuckle/training/training_task.h"

namespace knuckle {

/// The training of a network that infers poses from patches.
class PoseTrainingTask final : public TrainingTask {
 public:
  /// All samples have to live as long as this. `training` are views with `augmentation`.
  PoseTrainingTask(const NetworkOptions& network, const AugmentationOptions& augmentation,
                   std::shared_ptr<const SampleViews> training, const CubeSamples& validation);

  std::shared_ptr<TrainableModule> make_module(std::uint64_t seed) const override;
  std::shared_ptr<const SampleViews> views() const override { return views_; }
  std::vector<double> validate(TrainableModule& network, const torch::Device& device) const override;
  void save(const std::filesystem::path& path, const TrainableModule& network) const override;
  /// The file's network may tell less than this one: what it does not know begins with random weights.
  void load(const std::filesystem::path& path, TrainableModule& network) const override;
  std::string identity(const std::string& training) const override;

 private:
  /// Sizes and weights of several sets, and in which order they are read where they are not in memory.
  std::string sets_text() const;

  NetworkOptions options_;
  AugmentationOptions augmentation_;
  std::shared_ptr<const SampleViews> views_;
  const CubeSamples& validation_;
};

}  // namespace knuckle
