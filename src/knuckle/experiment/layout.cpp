// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/layout.h"

namespace knuckle {

std::filesystem::path ExperimentFolder::model(const PlannedModel& model) const {
  return folder_ / "models" / model.file;
}

std::filesystem::path ExperimentFolder::metrics(const std::filesystem::path& model) {
  return model.string() + ".metrics.csv";
}

std::filesystem::path ExperimentFolder::training_record(const std::filesystem::path& model) {
  return model.string() + ".training.json";
}

std::filesystem::path ExperimentFolder::training_config(const PlannedModel& model) const {
  return folder_ / "training" / (model.file + ".toml");
}

std::filesystem::path ExperimentFolder::pipeline(const PlannedMethod& method) const {
  return folder_ / "pipelines" / method.pipeline.filename();
}

std::filesystem::path ExperimentFolder::boxes(const PlannedSequence& sequence,
                                              const PlannedMethod& method) const {
  return details(sequence) / "boxes" / (method.stem() + ".csv");
}

std::filesystem::path ExperimentFolder::poses(const PlannedSequence& sequence,
                                              const PlannedMethod& method) const {
  return details(sequence) / "poses" / (method.stem() + ".txt");
}

std::filesystem::path ExperimentFolder::summary(std::filesystem::path result) {
  return result.replace_extension(".json");
}

}  // namespace knuckle
