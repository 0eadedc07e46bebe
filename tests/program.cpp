// SPDX-License-Identifier: Apache-2.0
#include "program.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

#include <fcntl.h>
#include <spawn.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/text_file.h"

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

/// Waits for the process to end, which gets `signal` when `is_time` says so.
int wait_for(pid_t process, const std::function<bool()>& is_time, int signal) {
  int wait_status = 0;
  if (!is_time) {
    ::waitpid(process, &wait_status, 0);
    return wait_status;
  }
  bool is_sent = false;
  while (::waitpid(process, &wait_status, WNOHANG) == 0) {
    if (!is_sent && is_time()) is_sent = ::kill(process, signal) == 0;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return wait_status;
}

/// A program does not catch what it was started to ignore, and whoever runs the tests may ignore Ctrl-C.
class DefaultSignals {
 public:
  DefaultSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGDEF);
  }
  DefaultSignals(const DefaultSignals&) = delete;
  DefaultSignals& operator=(const DefaultSignals&) = delete;
  ~DefaultSignals() { posix_spawnattr_destroy(&attributes_); }

  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_{};
};

ProgramRun run_command(std::vector<std::string> command, const std::function<bool()>& is_time = {},
                       int signal = SIGKILL) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const std::string error = folder / "error";

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, error.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t process = 0;
  const int fault = posix_spawnp(&process, command.front().c_str(), &actions, DefaultSignals().get(),
                                 as_pointers(command).data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (fault != 0) throw std::runtime_error("cannot start " + command.front());

  const int wait_status = wait_for(process, is_time, signal);
  return {status_of(wait_status), read_text_file(out), read_text_file(error)};
}

}  // namespace

ProgramRun run_program(const std::vector<std::string>& arguments) {
  return run_program_until({}, arguments);
}

ProgramRun run_program_until(const std::function<bool()>& is_time, const std::vector<std::string>& arguments,
                             int signal) {
  std::vector<std::string> command = {KNUCKLE_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(std::move(command), is_time, signal);
}

ProgramRun run_program_on_full_disk(int kilobytes, const std::vector<std::string>& arguments) {
  // The limit's signal is ignored, so that a write that goes beyond it fails as on a full disk.
  const std::string limited = fmt::format("trap '' XFSZ; ulimit -f {}; exec \"$@\"", kilobytes);
  std::vector<std::string> command = {"bash", "-c", limited, "bash", KNUCKLE_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(std::move(command));
}

std::optional<ProgramRun> run_program_as_ordinary_user(const std::vector<std::string>& arguments) {
  std::vector<std::string> command;
  if (::geteuid() == 0) command = {"setpriv", "--reuid=nobody", "--regid=nogroup", "--clear-groups"};
  command.emplace_back(KNUCKLE_PROGRAM);
  std::vector<std::string> version = command;
  version.emplace_back("--version");
  try {
    if (run_command(std::move(version)).status != 0) return std::nullopt;
  } catch (const std::runtime_error&) {
    return std::nullopt;  // no setpriv
  }
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(std::move(command));
}

std::vector<std::string> error_lines(const ProgramRun& run) {
  std::istringstream text(run.error);
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    if (line.find(", time left ") == std::string::npos) lines.push_back(line);
  }
  return lines;
}

SmallDisk::SmallDisk(std::filesystem::path place) : place_(std::move(place)) {
  std::filesystem::create_directories(place_);
}

SmallDisk::~SmallDisk() {
  ::umount(place_.c_str());
}

bool SmallDisk::mount(int kilobytes) const {
  const std::string size = fmt::format("size={}k", kilobytes);
  return ::mount("tmpfs", place_.c_str(), "tmpfs", 0, size.c_str()) == 0;
}

bool SmallDisk::resize(int kilobytes) const {
  const std::string size = fmt::format("size={}k", kilobytes);
  return ::mount("tmpfs", place_.c_str(), "tmpfs", MS_REMOUNT, size.c_str()) == 0;
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

std::map<std::string, std::filesystem::file_time_type> write_times(const std::filesystem::path& folder) {
  std::map<std::string, std::filesystem::file_time_type> times;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    times[std::filesystem::relative(entry.path(), folder).string()] = entry.last_write_time();
  }
  return times;
}

}  // namespace knuckle::testing
