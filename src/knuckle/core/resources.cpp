// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/resources.h"

#include <cstdlib>

namespace knuckle {

std::filesystem::path resource_path(std::string_view relative) {
  if (const char* home = std::getenv("KNUCKLE_HOME")) return std::filesystem::path(home) / relative;
  const std::filesystem::path source_tree = KNUCKLE_SOURCE_TREE;
  if (std::filesystem::is_directory(source_tree / "pipelines")) return source_tree / relative;
  std::error_code ignored;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", ignored);
  return program.parent_path().parent_path() / "share/knuckle" / relative;
}

}  // namespace knuckle
