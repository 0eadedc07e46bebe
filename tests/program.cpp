// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include <algorithm>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include "knuckle/core/file_io.h"

extern char** environ;

namespace knuckle::testing {
namespace {

std::vector<char*> as_pointers(std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  return pointers;
}

int status_of(int wait_status) {
  return WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : 128 + WTERMSIG(wait_status);
}

}  // namespace

ProgramRun run_program(const std::vector<std::string>& arguments) {
  const TemporaryFolder folder;
  std::vector<std::string> command = {KNUCKLE_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const std::string out = folder / "out";
  const std::string error = folder / "error";

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, error.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t process = 0;
  const int fault = posix_spawn(&process, KNUCKLE_PROGRAM, &actions, nullptr, as_pointers(command).data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (fault != 0) throw std::runtime_error("cannot start " KNUCKLE_PROGRAM);

  int wait_status = 0;
  ::waitpid(process, &wait_status, 0);
  return {status_of(wait_status), read_text_file(out), read_text_file(error)};
}

std::vector<std::string> entries_of(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace knuckle::testing
