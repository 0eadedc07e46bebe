// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <torch/types.h>

#include "knuckle/training/sample_views.h"
#include "knuckle/training/trainable_module.h"

namespace knuckle {

/// What is trained, on what, and how good it is: all in which one kind of network differs from another.
class TrainingTask {
 public:
  virtual ~TrainingTask() = default;
  /// A network with random weights that depend on `seed` alone.
  virtual std::shared_ptr<TrainableModule> make_module(std::uint64_t seed) const = 0;
  /// The samples that are trained on.
  virtual std::shared_ptr<const SampleViews> views() const = 0;
  /// What a network in evaluation achieves on the samples that are not trained on. The last number says which
  /// network is best: the one where it is smallest; it is finite, or the network is of no use.
  virtual std::vector<double> validate(TrainableModule& network, const torch::Device& device) const = 0;
  /// Writes a network for inference.
  virtual void save(const std::filesystem::path& path, const TrainableModule& network) const = 0;
  /// Sets a network to what `save` wrote. Throws an Error where the file is of another kind of network.
  virtual void load(const std::filesystem::path& path, TrainableModule& network) const = 0;
  /// All that must be the same for a training to go on, but where it began; `training` are its options.
  virtual std::string identity(const std::string& training) const = 0;
};

}  // namespace knuckle
