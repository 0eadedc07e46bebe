// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/local_workers.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <system_error>
#include <thread>

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/workers/worker_place.h"

namespace knuckle {
namespace {

constexpr auto kTimeToEnd = std::chrono::seconds(10);
constexpr auto kPause = std::chrono::milliseconds(10);

std::filesystem::path new_folder() {
  std::error_code unknown;
  const std::filesystem::path place = std::filesystem::temp_directory_path(unknown);
  std::string name = ((unknown ? std::filesystem::path("/tmp") : place) / "knuckle-workers-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) {
    fail("{}: cannot be made, for the workers to meet in: {}", name, std::strerror(errno));
  }
  return name;
}

/// This process's environment, with two variables more.
std::vector<std::string> environment_of(int rank, const std::filesystem::path& folder) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) variables.emplace_back(*variable);
  variables.push_back(fmt::format("{}={}", kRankVariable, rank));
  variables.push_back(fmt::format("{}={}", kFolderVariable, folder.string()));
  return variables;
}

/// Pointers to texts, as the system's calls expect them.
std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

LocalWorkers::LocalWorkers() : folder_(new_folder()) {}

// What another constructor has made is taken away again where this one throws.
LocalWorkers::LocalWorkers(const std::vector<std::string>& command_line, int count) : LocalWorkers() {
  for (int rank = 1; rank < count; ++rank) start(command_line, rank);
}

void LocalWorkers::start(const std::vector<std::string>& command_line, int rank) {
  std::vector<std::string> arguments = command_line;
  std::vector<std::string> variables = environment_of(rank, folder_);
  pid_t process = 0;
  const int fault = ::posix_spawn(&process, "/proc/self/exe", nullptr, nullptr, pointers_to(arguments).data(),
                                  pointers_to(variables).data());
  if (fault != 0) fail("--workers: worker {} cannot be started: {}", rank, std::strerror(fault));
  children_.push_back({process, std::nullopt});
}

bool LocalWorkers::have_ended() {
  for (Child& child : children_) {
    int status = 0;
    if (!child.status && ::waitpid(child.process, &status, WNOHANG) == child.process) child.status = status;
  }
  return std::ranges::all_of(children_, [](const Child& child) { return child.status.has_value(); });
}

LocalWorkers::~LocalWorkers() {
  const auto end = std::chrono::steady_clock::now() + kTimeToEnd;
  while (!have_ended() && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(kPause);
  for (const Child& child : children_) {
    if (child.status) continue;
    ::kill(child.process, SIGKILL);
    ::waitpid(child.process, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::optional<std::string> LocalWorkers::fault() {
  have_ended();
  for (std::size_t i = 0; i < children_.size(); ++i) {
    const std::optional<int>& status = children_[i].status;
    if (!status || *status == 0) continue;
    const std::string how = WIFSIGNALED(*status) ? fmt::format("was ended by signal {}", WTERMSIG(*status))
                                                 : fmt::format("ended with status {}", WEXITSTATUS(*status));
    return fmt::format("worker {} of {} {}", i + 1, children_.size() + 1, how);
  }
  return std::nullopt;
}

}  // namespace knuckle
