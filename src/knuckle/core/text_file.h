// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace knuckle {

/// The whole file as text. Throws an Error that names the file where it cannot be read.
std::string read_text_file(const std::filesystem::path& path);

/// The file's lines without their ends (line feed, or carriage return and line feed). A last line without an
/// end counts.
std::vector<std::string> read_lines(const std::filesystem::path& path);

/// A line of a file that says something.
struct ContentLine {
  std::string text;   ///< without its end
  std::string where;  ///< "file:12", for messages
};

/// The lines of a file that are neither blank nor start with #.
std::vector<ContentLine> read_content_lines(const std::filesystem::path& path);

}  // namespace knuckle
