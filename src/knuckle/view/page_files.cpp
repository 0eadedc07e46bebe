// SPDX-License-Identifier: Apache-2.0
#include "knuckle/view/page_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

constexpr std::size_t kMostFiles = 256;
constexpr std::uintmax_t kMostBytes = 64U << 20U;
constexpr int kDeepest = 3;  // folders in folders

struct PageFileKind {
  std::string_view name;  ///< extension
  std::string_view content_type;
};
constexpr std::array kKinds{
    PageFileKind{".html", "text/html; charset=utf-8"},
    PageFileKind{".js", "text/javascript; charset=utf-8"},
    PageFileKind{".css", "text/css; charset=utf-8"},
    PageFileKind{".json", "application/json"},
    PageFileKind{".map", "application/json"},
    PageFileKind{".svg", "image/svg+xml"},
    PageFileKind{".png", "image/png"},
    PageFileKind{".ico", "image/x-icon"},
    PageFileKind{".woff2", "font/woff2"},
    PageFileKind{".wasm", "application/wasm"},
    PageFileKind{".txt", "text/plain; charset=utf-8"},
};

bool is_plain_name(std::string_view name) {
  return !name.starts_with('.') && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
  });
}

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) fail("{}: cannot be read", path.string());
  return bytes;
}

}  // namespace

PageFiles read_page_files(const fs::path& folder, const std::string& index) {
  PageFiles files;
  std::error_code missing;
  std::uintmax_t bytes = 0;
  for (fs::recursive_directory_iterator entry(folder, missing), end; !missing && entry != end;
       entry.increment(missing)) {
    const bool is_folder = entry->is_directory();
    const std::string name = entry->path().filename().string();
    if (is_folder && (!is_plain_name(name) || entry.depth() == kDeepest)) entry.disable_recursion_pending();
    const PageFileKind* const kind = row_named(kKinds, entry->path().extension().string());
    if (is_folder || entry->is_symlink() || !entry->is_regular_file() || !is_plain_name(name) || !kind)
      continue;
    bytes += entry->file_size();
    if (files.size() == kMostFiles || bytes > kMostBytes)
      fail("{}: is more than a page: over {} files or {} bytes", folder.string(), kMostFiles, kMostBytes);
    const std::string path = entry->path().lexically_relative(folder).generic_string();
    files[fmt::format("/{}", path)] = {kind->content_type, content_of(entry->path())};
  }
  if (const auto found = files.find("/" + index); found != files.end()) files["/"] = found->second;
  return files;
}

}  // namespace knuckle
