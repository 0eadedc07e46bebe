// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/sibling_program.h"

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include <unistd.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"

namespace knuckle::cli {

void become_sibling(const std::string& program) {
  std::error_code unknown;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", unknown);
  if (unknown) fail("{}: cannot be found: {}", program, unknown.message());
  const std::filesystem::path path = self.parent_path() / program;
  if (!std::filesystem::exists(path)) {
    fail("{}: is missing: it does this kind of training, and belongs beside {}; scripts/build.sh builds it",
         path.string(), self.string());
  }
  std::vector<std::string> arguments = command_line_arguments();
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  std::fflush(nullptr);
  hold_interruption();
  end_if_interrupted();
  ::execv(path.c_str(), pointers.data());
  fail("{}: cannot be started: {}", path.string(), std::generic_category().message(errno));
}

}  // namespace knuckle::cli
