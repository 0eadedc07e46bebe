// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// The whole file as text. Throws an Error that names the file where it cannot be read.
std::string read_text_file(const std::filesystem::path& path);

/// A line of a text file while it is looked at.
struct FileLine {
  std::string_view text;  ///< without its end
  std::size_t number;     ///< from 1
  const std::filesystem::path& file;

  std::string where() const;  ///< "file:12", for messages
};

/// Shows the file's lines one after another, without their ends (line feed, or carriage return and line
/// feed); a last line without an end counts. One line at a time is in memory: a file of many short lines
/// takes no more than another. What `visit` throws ends it.
void visit_lines(const std::filesystem::path& path, const std::function<void(const FileLine&)>& visit);

/// The lines that are neither blank nor start with #.
void visit_content_lines(const std::filesystem::path& path,
                         const std::function<void(const FileLine&)>& visit);

/// All lines of a file of our own, which is short.
std::vector<std::string> read_lines(const std::filesystem::path& path);

}  // namespace knuckle
