// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace knuckle {

/// Throws an Error that names `path` where it is missing or not a regular file: a folder, or a FIFO, device
/// or socket, which would never end. For what a library opens by its name.
void require_regular_file(const std::filesystem::path& path);

/// All bytes of a regular file. Throws an Error that names it where it cannot be read, is not a regular file,
/// or has more than `most_bytes`; before memory is taken.
std::string read_regular_file(const std::filesystem::path& path, std::int64_t most_bytes);

}  // namespace knuckle
