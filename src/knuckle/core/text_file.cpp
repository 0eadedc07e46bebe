// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text_file.h"

#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {

std::string read_text_file(const std::filesystem::path& path) {
  errno = 0;
  if (std::filesystem::is_directory(path)) fail("{}: expected a file, found a folder", path.string());
  std::ifstream stream(path, std::ios::binary);
  if (!stream) fail("{}: cannot read: {}", path.string(), std::generic_category().message(errno));
  std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (stream.bad()) fail("{}: cannot read: {}", path.string(), std::generic_category().message(errno));
  return text;
}

std::vector<std::string> read_lines(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const bool has_return = end > begin && text[end - 1] == '\r';
    lines.push_back(text.substr(begin, end - begin - (has_return ? 1 : 0)));
    begin = end + 1;
  }
  return lines;
}

std::vector<ContentLine> read_content_lines(const std::filesystem::path& path) {
  std::vector<ContentLine> content;
  std::size_t number = 0;
  for (std::string& line : read_lines(path)) {
    ++number;
    const std::string_view text = trimmed(line);
    if (text.empty() || text.starts_with('#')) continue;
    content.push_back({std::move(line), fmt::format("{}:{}", path.string(), number)});
  }
  return content;
}

}  // namespace knuckle
