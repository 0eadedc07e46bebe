// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/resources.h"

#include <cstdlib>
#include <mutex>

#include <dlfcn.h>
#include <link.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

namespace fs = std::filesystem;

constexpr const char* kInstalledFolder = "share/knuckle";
constexpr const char* kHelperFolder = "libexec/knuckle";
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

/// The shared library that contains this function, or the program where it was linked into that.
fs::path own_file() {
  Dl_info ignored{};
  link_map* library = nullptr;
  const int found = ::dladdr1(reinterpret_cast<void*>(&own_file), &ignored,
                              reinterpret_cast<void**>(&library), RTLD_DL_LINKMAP);
  const bool is_library = found != 0 && library != nullptr && library->l_name[0] != '\0';
  std::error_code unknown;
  const fs::path path = fs::canonical(is_library ? library->l_name : "/proc/self/exe", unknown);
  return unknown ? fs::path() : path;
}

/// What lies at a place in our own folder, or the nearest one above it; empty where nothing does.
fs::path find_at_or_above(const fs::path& place) {
  fs::path folder = own_file().parent_path();
  std::error_code unknown;
  for (int above = 0; above <= kFoldersAbove; ++above, folder = folder.parent_path()) {
    // A build's share/knuckle is a link to the source tree: that is the name to show.
    if (fs::exists(folder / place, unknown)) return fs::canonical(folder / place);
  }
  return {};
}

fs::path find_installed_folder() {
  fs::path found = find_at_or_above(kInstalledFolder);
  if (!found.empty()) return found;
  fail(
      "Knuckle's models and pipelines cannot be found: there is no {} in {} or the {} folders above it; "
      "install "
      "Knuckle as a whole, set KNUCKLE_HOME to the folder that holds models/ and pipelines/, or call "
      "set_data_folder() in your program",
      kInstalledFolder, own_file().parent_path().string(), kFoldersAbove);
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

fs::path helper_program(std::string_view name) {
  const fs::path place = fs::path(kHelperFolder) / name;
  fs::path found = find_at_or_above(place);
  if (!found.empty()) return found;
  fail("{} cannot be found: there is no {} in {} or the {} folders above it; install Knuckle as a whole",
       name, place.string(), own_file().parent_path().string(), kFoldersAbove);
}

}  // namespace knuckle
