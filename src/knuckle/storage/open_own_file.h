// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace knuckle {

/// Opens a file that this program writes under a name that others can guess, such as `F.partial`: for reading
/// and writing, never through a link that somebody laid there, and without waiting for the other end of a
/// pipe. `flags` are more flags of open(2), such as O_CREAT. -1 where it cannot be opened; errno says why.
/// Throws an Error that names `path` where it is no regular file.
int open_own_file(const std::filesystem::path& path, int flags);

/// `open_own_file` for one run alone: throws an Error where another one has the file open so (`in_use` says
/// what to do), and where it cannot be opened.
int open_own_file_alone(const std::filesystem::path& path, int flags, const char* in_use);

}  // namespace knuckle
