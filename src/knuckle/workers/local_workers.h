// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace knuckle {

/// The other workers of one machine: processes of this program with the same command line, started by worker
/// 0, and the folder in which they meet, which only this user may read.
class LocalWorkers {
 public:
  /// Starts workers 1 to `count` - 1. Throws an Error where one cannot be started.
  LocalWorkers(const std::vector<std::string>& command_line, int count);
  /// Waits a while until they have ended by themselves, then ends them, and removes the folder.
  ~LocalWorkers();
  LocalWorkers(const LocalWorkers&) = delete;
  LocalWorkers& operator=(const LocalWorkers&) = delete;

  const std::filesystem::path& folder() const { return folder_; }
  /// The first worker that has ended and should not have, and how: "worker 1 of 2 was ended by signal 9".
  std::optional<std::string> fault();

 private:
  LocalWorkers();

  struct Child {
    pid_t process;
    std::optional<int> status;  // as waitpid has it, after the end
  };
  void start(const std::vector<std::string>& command_line, int rank);
  bool have_ended();

  std::filesystem::path folder_;
  std::vector<Child> children_;  // worker 1 first
};

}  // namespace knuckle
