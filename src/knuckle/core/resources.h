// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

namespace knuckle {

/// The place of a file that comes with Knuckle, as in resource_path("pipelines/default.toml"): below
/// $KNUCKLE_HOME where that is set; else below ../share/knuckle beside the program's folder where Knuckle is
/// installed there; else below the source tree that the library was built from. Whether the file exists is
/// for its reader to find out.
std::filesystem::path resource_path(std::string_view relative);

}  // namespace knuckle
