// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// Throws an Error that names the folder where there is none.
void require_folder(const std::filesystem::path& folder);

/// Names of the files in `folder` that start with `prefix` and end with `suffix`, sorted by name. Asks the
/// file system for names only, so that 400,000 files take a second. Throws an Error where the folder cannot
/// be read.
std::vector<std::string> list_files(const std::filesystem::path& folder, std::string_view prefix,
                                    std::string_view suffix);

/// Shows the path of every file in `folder` and below it, relative to it with '/' between, in no order. Links
/// to files are files, wherever they lead; folders that are links are not entered.
void visit_files_below(const std::filesystem::path& folder,
                       const std::function<void(std::string_view)>& visit);

/// All files in the folder and below it that end with `suffix`; paths relative to `folder` with '/' between,
/// sorted.
std::vector<std::string> list_files_below(const std::filesystem::path& folder, std::string_view suffix);

/// The text without its last `.extension`, if it has one.
std::string without_extension(std::string_view name);

}  // namespace knuckle
