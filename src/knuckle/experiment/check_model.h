// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace knuckle {

/// Throws an Error that names the file and what is wrong where `model` is not what a training of the kind
/// `kind` with this configuration makes: missing, damaged, of another kind or architecture, for other
/// landmarks, or for other patches. How well, and on what frames, it was trained is not asked.
void check_model(std::string_view kind, const std::filesystem::path& config,
                 const std::filesystem::path& model);

}  // namespace knuckle
