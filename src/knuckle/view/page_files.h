// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

namespace knuckle {

/// A file of the page, as it is sent.
struct PageFile {
  std::string_view content_type;  ///< as in "text/html; charset=utf-8"
  std::string bytes;
};

/// The files of a page, in memory, by the path that asks for them ("/app.js"; "/" is the index): what is not
/// in this list is not served, and no path of a request is ever looked up on the disk.
using PageFiles = std::map<std::string, PageFile, std::less<>>;

/// Reads the files of a folder and of those in it; `index` is the one that "/" is: plain files alone (no
/// links, nothing hidden), names of letters, digits, '.', '_' and '-', kinds that a page consists of. Nothing
/// where the folder is not there: then no page is installed. Throws an Error that names the file that cannot
/// be read, and where all of them exceed 64 MB or 256 files.
PageFiles read_page_files(const std::filesystem::path& folder, const std::string& index = "index.html");

}  // namespace knuckle
