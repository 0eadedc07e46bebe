// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace knuckle {

/// The source that a configuration of `knuckle train KIND` names. Throws an Error that lists the kinds where
/// `kind` is none of them.
std::string training_source(std::string_view kind, const std::filesystem::path& config);

/// Trains as `knuckle train KIND --config CONFIG --out OUT --resume` does, on the first part of its frames:
/// `scale` in (0, 1].
void train_model(std::string_view kind, const std::filesystem::path& config, double scale,
                 const std::filesystem::path& out);

/// The source cut down to its first frames, at least one: a `scale` in (0, 1] of what it has.
std::string scaled_source(const std::string& source, double scale);

}  // namespace knuckle
