// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// What a training is told: a configuration of `knuckle train KIND`, made small.
struct ScaledTraining {
  std::filesystem::path config;
  std::vector<std::string> sources;           ///< that its frames come from
  std::vector<std::filesystem::path> models;  ///< that it starts from
};

/// Writes the configuration `original` of a training of the kind `kind` at scale `s` (scale.h; the table of
/// rules is in training_config.cpp) as `config`, with all paths absolute.
/// Manifests of synthetic frames, which then show fewer people, are written beside it. A file that would stay
/// the same is left alone. Throws an Error that names the original, line and key where that is wrong.
ScaledTraining write_scaled_training(std::string_view kind, const std::filesystem::path& original, double s,
                                     const std::filesystem::path& config);

}  // namespace knuckle
