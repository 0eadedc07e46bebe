// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "knuckle/core/shard.h"

namespace knuckle {

/// Joins the parts of a set that was made in several, as one file: of the same bytes as if it had been made
/// in one piece by the same program. Returns the frames that it holds. Throws an Error as H5Parts does where
/// parts are missing, twice there, wrong or of another set, one that names all parts that are damaged, and
/// one where `out` exists or cannot be written.
IndexRange join_parts(const std::vector<std::filesystem::path>& parts, const std::filesystem::path& out);

}  // namespace knuckle
