// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/file_listing.h"

#include <algorithm>
#include <system_error>

#include "knuckle/core/error.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// All but folders. A FIFO, a device or a link to nothing is an error of whoever reads it, not a frame less;
/// a file that went away meanwhile is none.
bool is_listed(const fs::directory_entry& entry) {
  std::error_code ignored;
  if (entry.is_regular_file(ignored)) return true;
  return fs::exists(entry.symlink_status(ignored)) && !entry.is_directory(ignored);
}

/// Walks with `Iterator` (flat or recursive) and shows each file's path relative to `folder`.
template <class Iterator>
void visit_with(const fs::path& folder, const std::function<void(std::string_view)>& visit) {
  require_folder(folder);
  const fs::path root = folder / "";
  std::error_code error;
  for (Iterator entry(root, error), end; !error && entry != end; entry.increment(error)) {
    if (is_listed(*entry)) visit(std::string_view(entry->path().native()).substr(root.native().size()));
  }
  if (error) fail("{}: cannot list the folder: {}", folder.string(), error.message());
}

}  // namespace

void require_folder(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (!fs::exists(status)) fail("{}: no such folder", folder.string());
  if (!fs::is_directory(status)) fail("{}: is not a folder", folder.string());
}

std::vector<std::string> list_files(const fs::path& folder, std::string_view prefix,
                                    std::string_view suffix) {
  std::vector<std::string> names;
  visit_with<fs::directory_iterator>(folder, [&](std::string_view name) {
    if (name.starts_with(prefix) && name.ends_with(suffix)) names.emplace_back(name);
  });
  std::ranges::sort(names);
  return names;
}

void visit_files_below(const fs::path& folder, const std::function<void(std::string_view)>& visit) {
  visit_with<fs::recursive_directory_iterator>(folder, visit);
}

std::vector<std::string> list_files_below(const fs::path& folder, std::string_view suffix) {
  std::vector<std::string> paths;
  visit_files_below(folder, [&](std::string_view path) {
    if (path.ends_with(suffix)) paths.emplace_back(path);
  });
  std::ranges::sort(paths);
  return paths;
}

std::string without_extension(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  const std::size_t slash = name.rfind('/');
  const bool has_extension =
      dot != std::string_view::npos && (slash == std::string_view::npos || dot > slash);
  return std::string(has_extension ? name.substr(0, dot) : name);
}

}  // namespace knuckle
