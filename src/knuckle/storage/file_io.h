// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace knuckle {

/// Writes a file so that it appears under its name only when whole: `write` fills a temporary file beside it
/// (it is handed that path; the file is there, empty, under a name that nobody can guess), which is then
/// flushed to the disk and renamed. A link of that name is replaced, not followed; a folder, a device, a pipe
/// or a socket is refused. Whatever goes wrong (an exception of `write`, a full disk), the temporary file is
/// removed, a former file of that name stays, and an Error names `path`.
void write_file_atomically(const std::filesystem::path& path,
                           const std::function<void(const std::filesystem::path& temporary)>& write);

/// Hands the names in a file's folder to the disk: a rename is there when its folder is. Not every file
/// system can do that; it is no fault then.
void sync_folder_of(const std::filesystem::path& path);

/// Flushes a file that is whole to the disk, gives it its final name and flushes that, too. An Error names
/// `path`.
void publish_file(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// Writes `text` as a file, atomically.
void write_text_file(const std::filesystem::path& path, std::string_view text);

/// Throws an Error that names `path` where no file can be written there: for the beginning of long work, so
/// that its result is not lost at the end. Leaves nothing behind, and a file of that name as it is.
void check_writable(const std::filesystem::path& path);

/// Makes the folder and those above it. Throws an Error that names it.
void make_folder(const std::filesystem::path& folder);

}  // namespace knuckle
