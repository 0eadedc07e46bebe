// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/resources.h"

#include <cstdlib>

namespace knuckle {

std::filesystem::path resource_path(std::string_view relative) {
  if (const char* home = std::getenv("KNUCKLE_HOME")) return std::filesystem::path(home) / relative;
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  const std::filesystem::path installed = program.parent_path().parent_path() / "share/knuckle";
  const bool is_installed = std::filesystem::is_directory(installed / "pipelines", ignored);
  return (is_installed ? installed : std::filesystem::path(KNUCKLE_SOURCE_TREE)) / relative;
}

}  // namespace knuckle
