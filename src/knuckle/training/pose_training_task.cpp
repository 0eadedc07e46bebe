// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/pose_training_task.h"

#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/net/network_file.h"
#include "knuckle/training/network_module.h"
#include "knuckle/training/network_validation.h"
#include "knuckle/training/network_writer.h"

namespace knuckle {

namespace {

/// Whether the maps of one network are the first of the other's, and all else is the same but what answers
/// weigh in the loss.
bool begins(NetworkOptions known, const NetworkOptions& options) {
  const DenseNetworkOptions& wanted = options.dense;
  const bool tells_the_same_side = known.dense.tells_side == wanted.tells_side;
  const bool tells_neither = !known.dense.tells_side && !known.dense.tells_hand;
  if (!tells_neither && !(tells_the_same_side && (wanted.tells_hand || !known.dense.tells_hand)))
    return false;
  known.dense.tells_side = wanted.tells_side;
  known.dense.tells_hand = wanted.tells_hand;
  known.dense.question_weight = wanted.question_weight;
  return network_options_as_toml(known) == network_options_as_toml(options);
}

}  // namespace

PoseTrainingTask::PoseTrainingTask(const NetworkOptions& network, const AugmentationOptions& augmentation,
                                   std::shared_ptr<const SampleViews> training, const CubeSamples& validation)
    : options_(network), augmentation_(augmentation), views_(std::move(training)), validation_(validation) {}

std::shared_ptr<TrainableModule> PoseTrainingTask::make_module(std::uint64_t seed) const {
  return make_network(options_, seed);
}

std::vector<double> PoseTrainingTask::validate(TrainableModule& network, const torch::Device& device) const {
  return validation_errors(dynamic_cast<NetworkModule&>(network), validation_, device);
}

void PoseTrainingTask::save(const std::filesystem::path& path, const TrainableModule& network) const {
  save_network(path, options_, dynamic_cast<const NetworkModule&>(network));
}

void PoseTrainingTask::load(const std::filesystem::path& path, TrainableModule& network) const {
  const NetworkWeights weights = load_network_weights(path);
  if (!begins(weights.options(), options_)) {
    fail("{}: training cannot begin with it: its [network] or [patch] differs from the configuration's",
         path.string());
  }
  set_weights(network, weights);
}

std::string PoseTrainingTask::identity(const std::string& training) const {
  return network_options_as_toml(options_) + "[training]\n" + training + "[augmentation]\n" +
         options_as_toml(augmentation_) + sets_text();
}

/// One set's size is told apart by the trainer.
std::string PoseTrainingTask::sets_text() const {
  const std::vector<SampleGroup> groups = views_->groups();
  std::string text;
  for (const SampleGroup& group : groups) {
    if (groups.size() > 1)
      text += fmt::format("[[source]]\nsamples = {}\nweight = {}\n", group.size, group.weight);
    if (group.window > 0 && group.window < group.size && group.runs.size() > 1)
      text += fmt::format("stream_window = {}\n", group.window);
  }
  return text;
}

}  // namespace knuckle
