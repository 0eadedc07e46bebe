// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/resources.h"

#include <cstdlib>
#include <mutex>

#include "knuckle/core/error.h"
#include "knuckle/core/own_file.h"

namespace knuckle {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInstalledFolder = "share/knuckle";
// From PREFIX/lib/x86_64-linux-gnu/glibc-hwcaps/x86-64-v3, where a processor's own variant of the library
// lies, it is four folders up to PREFIX.
constexpr int kFoldersAbove = 4;

/// What set_data_folder was told.
class ChosenFolder {
 public:
  void set(fs::path folder) {
    const std::lock_guard lock(mutex_);
    folder_ = std::move(folder);
  }
  fs::path get() const {
    const std::lock_guard lock(mutex_);
    return folder_;
  }

 private:
  mutable std::mutex mutex_;
  fs::path folder_;
};

ChosenFolder& chosen_folder() {
  static ChosenFolder folder;
  return folder;
}

fs::path find_installed_folder() {
  const fs::path start = own_file().parent_path();
  fs::path folder = start;
  std::error_code unknown;
  for (int above = 0; above <= kFoldersAbove; ++above, folder = folder.parent_path()) {
    // A build's share/knuckle is a link to the source tree: that is the name to show.
    if (fs::is_directory(folder / kInstalledFolder, unknown)) return fs::canonical(folder / kInstalledFolder);
  }
  fail(
      "Knuckle's models and pipelines cannot be found: there is no {} in {} or the {} folders above it; "
      "install "
      "Knuckle as a whole, set KNUCKLE_HOME to the folder that holds models/ and pipelines/, or call "
      "set_data_folder() in your program",
      kInstalledFolder, start.string(), kFoldersAbove);
}

}  // namespace

void set_data_folder(const fs::path& folder) {
  std::error_code unknown;
  if (!fs::is_directory(folder, unknown)) {
    fail(
        "{}: set_data_folder() expects the folder that holds Knuckle's models and pipelines; this is not a "
        "folder",
        folder.string());
  }
  chosen_folder().set(fs::absolute(folder));
}

fs::path resource_path(std::string_view relative) {
  const fs::path chosen = chosen_folder().get();
  if (!chosen.empty()) return chosen / relative;
  if (const char* home = std::getenv("KNUCKLE_HOME")) return fs::path(home) / relative;
  static const fs::path installed = find_installed_folder();
  return installed / relative;
}

}  // namespace knuckle
