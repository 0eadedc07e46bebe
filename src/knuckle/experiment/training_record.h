// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "knuckle/core/pose.h"

namespace knuckle {

/// How a model came to be: the file MODEL.training.json, and what the metrics of a network's training add.
struct TrainingRecord {
  std::string model;              ///< name of its file
  std::filesystem::path given;    ///< where it was taken from; empty: it was trained here
  std::optional<double> seconds;  ///< of its training; of the last run alone where a forest's was stopped
  std::optional<std::int64_t> samples;  ///< that a network has seen, each as often as it came
  double validation_mm = kNaN;          ///< a network's least error in validation, mean over joints
};

/// Notes beside a model where it was taken from.
void write_given_record(const std::filesystem::path& model, const std::filesystem::path& given);
/// Notes beside a model how long its training took.
void write_trained_record(const std::filesystem::path& model, double seconds);

/// Reads the notes; a network's time and samples are taken from its metrics, which count all runs of a
/// training that was stopped and went on. Throws an Error that names a damaged file.
TrainingRecord read_training_record(const std::filesystem::path& model);

}  // namespace knuckle
