// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/experiment/plan.h"

namespace knuckle {

/// Where an experiment keeps its files.
class ExperimentFolder {
 public:
  explicit ExperimentFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path report() const { return folder_ / "report.html"; }
  std::filesystem::path figures() const { return folder_ / "figures"; }
  std::filesystem::path tables() const { return folder_ / "tables"; }    ///< the same for every run
  std::filesystem::path timings() const { return folder_ / "timings"; }  ///< different from run to run
  std::filesystem::path logs() const { return folder_ / "logs"; }        ///< of jobs
  std::filesystem::path samples() const { return folder_ / "samples"; }  ///< hands cut out for networks
  std::filesystem::path details(const PlannedSequence& sequence) const { return folder_ / sequence.name; }

  std::filesystem::path model(const PlannedModel& model) const;
  /// The metrics of a network's training, as `knuckle train network` writes them.
  static std::filesystem::path metrics(const std::filesystem::path& model);
  /// How a model came to be, see TrainingRecord.
  static std::filesystem::path training_record(const std::filesystem::path& model);
  /// What the training is told, at the scale of the experiment. The manifests of its frames lie beside it.
  std::filesystem::path training_config(const PlannedModel& model) const;

  std::filesystem::path pipeline(const PlannedMethod& method) const;
  std::filesystem::path boxes(const PlannedSequence& sequence, const PlannedMethod& method) const;
  std::filesystem::path poses(const PlannedSequence& sequence, const PlannedMethod& method) const;
  /// Counts and times, beside boxes or poses.
  static std::filesystem::path summary(std::filesystem::path result);

 private:
  std::filesystem::path folder_;
};

}  // namespace knuckle
