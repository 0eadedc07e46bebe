// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/line_index.h"

#include <fstream>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/regular_file.h"

namespace knuckle {
namespace {

constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r';
}

}  // namespace

LineIndex::LineIndex(std::filesystem::path path) : path_(std::move(path)) {
  require_regular_file(path_);
  std::ifstream file(path_, std::ios::binary);
  if (!file) fail("{}: cannot open the file", path_.string());
  std::vector<char> block(kBlockBytes);
  std::uint64_t offset = 0;
  std::uint64_t line_start = 0;
  std::uint32_t number = 1;
  bool is_undecided = true;  // of this line only blanks were seen
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0) {
    const char* const end = block.data() + file.gcount();
    for (const char* c = block.data(); c != end; ++c, ++offset) {
      if (offset - line_start > static_cast<std::uint64_t>(limits::kLineLength)) {
        fail("{}:{}: the line has more than {} characters", path_.string(), number, limits::kLineLength);
      }
      if (*c == '\n') {
        line_start = offset + 1;
        ++number;
        is_undecided = true;
      } else if (is_undecided && !is_blank(*c)) {
        is_undecided = false;
        if (*c == '#') continue;
        starts_.push_back(line_start);
        numbers_.push_back(number);
      }
    }
  }
  if (file.bad() || offset != std::filesystem::file_size(path_)) fail("{}: cannot be read", path_.string());
}

std::string LineIndex::line(std::int64_t index) const {
  if (index < 0 || index >= size())
    fail("{}: has {} entries, asked for entry {}", path_.string(), size(), index + 1);
  std::ifstream file(path_, std::ios::binary);
  const std::uint64_t start = starts_[static_cast<std::size_t>(index)];
  if (start > 0) file.seekg(static_cast<std::streamoff>(start - 1));
  std::string text;
  if ((start > 0 && file.get() != '\n') || !std::getline(file, text))
    fail("{}: cannot be read; the file was changed while it was read", where(index));
  if (text.ends_with('\r')) text.pop_back();
  return text;
}

std::string LineIndex::where(std::int64_t index) const {
  if (index < 0 || index >= size()) return path_.string();
  return fmt::format("{}:{}", path_.string(), numbers_[static_cast<std::size_t>(index)]);
}

}  // namespace knuckle
