// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/text_file.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr auto kMostLineBytes = static_cast<std::size_t>(limits::kLineLength);

/// Appends the file's next bytes; false at its end.
bool append_block(const RegularFile& file, const std::filesystem::path& path, std::string& text) {
  constexpr std::size_t kBlockBytes = std::size_t{1} << 17;
  const std::size_t length = text.size();
  text.resize(length + kBlockBytes);
  ssize_t count = 0;
  do {
    count = ::read(file.descriptor(), text.data() + length, kBlockBytes);
  } while (count < 0 && errno == EINTR);
  if (count < 0) fail("{}: cannot read: {}", path.string(), std::generic_category().message(errno));
  text.resize(length + static_cast<std::size_t>(count));
  return count > 0;
}

[[noreturn]] void fail_as_too_long(std::size_t length, std::size_t number,
                                   const std::filesystem::path& path) {
  fail("{}:{}: the line has {} characters, expected at most {}", path.string(), number, length,
       limits::kLineLength);
}

/// The length of a line that begins with `text`, of which no more is kept.
std::size_t length_of_line(const RegularFile& file, const std::filesystem::path& path, std::string text) {
  std::size_t length = text.size();
  for (bool is_over = false; !is_over;) {
    text.clear();
    is_over = !append_block(file, path, text) || text.find('\n') != std::string::npos;
    length += std::min(text.find('\n'), text.size());
  }
  return length;
}

/// Shows the whole lines of `text`, of which the first is line `number` + 1; the rest of it stays.
void show_lines(std::string& text, std::size_t& number, const std::filesystem::path& path,
                const std::function<void(const FileLine&)>& visit) {
  const std::string_view all = text;
  std::size_t begin = 0;
  while (begin < all.size()) {
    const std::size_t end = all.find('\n', begin);
    if (end == std::string_view::npos) break;
    std::string_view line = all.substr(begin, end - begin);
    if (line.size() > kMostLineBytes) fail_as_too_long(line.size(), number + 1, path);
    if (line.ends_with('\r')) line.remove_suffix(1);
    visit({line, ++number, path});
    begin = end + 1;
  }
  text.erase(0, begin);
}

}  // namespace

std::string read_text_file(const std::filesystem::path& path) {
  return read_regular_file(path, limits::kTextFileBytes);
}

std::string FileLine::where() const {
  return fmt::format("{}:{}", file.string(), number);
}

void visit_lines(const std::filesystem::path& path, const std::function<void(const FileLine&)>& visit) {
  const RegularFile file(path);
  if (file.size() > static_cast<std::uint64_t>(limits::kTextFileBytes)) {
    fail("{}: the file has {} bytes, expected at most {}", path.string(), file.size(),
         limits::kTextFileBytes);
  }
  std::string text;
  std::size_t number = 0;
  while (append_block(file, path, text)) {
    show_lines(text, number, path, visit);
    const bool is_too_long = text.size() > kMostLineBytes;
    if (is_too_long) fail_as_too_long(length_of_line(file, path, std::move(text)), number + 1, path);
  }
  if (text.empty()) return;
  text += '\n';  // the last line has no end
  show_lines(text, number, path, visit);
}

void visit_content_lines(const std::filesystem::path& path,
                         const std::function<void(const FileLine&)>& visit) {
  visit_lines(path, [&](const FileLine& line) {
    const std::string_view text = trimmed(line.text);
    if (!text.empty() && !text.starts_with('#')) visit(line);
  });
}

std::vector<std::string> read_lines(const std::filesystem::path& path) {
  std::vector<std::string> lines;
  visit_lines(path, [&](const FileLine& line) { lines.emplace_back(line.text); });
  return lines;
}

}  // namespace knuckle
