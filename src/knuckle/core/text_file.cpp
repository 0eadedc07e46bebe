// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text_file.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/text.h"

namespace knuckle {

std::string read_text_file(const std::filesystem::path& path) {
  return read_regular_file(path, limits::kTextFileBytes);
}

std::vector<std::string> read_lines(const std::filesystem::path& path) {
  const std::string text = read_text_file(path);
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const bool has_return = end > begin && text[end - 1] == '\r';
    if (end - begin > static_cast<std::size_t>(limits::kLineLength)) {
      fail("{}:{}: the line has {} characters, expected at most {}", path.string(), lines.size() + 1,
           end - begin, limits::kLineLength);
    }
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
