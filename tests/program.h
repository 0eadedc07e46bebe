// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "knuckle/core/testing.h"

namespace knuckle::testing {

/// What a run of the program left.
struct ProgramRun {
  int status = -1;  ///< exit status; 128 + the signal's number where a signal ended it
  std::string out;
  std::string error;
};

/// Runs the program with these arguments from the project's folder and waits for it.
ProgramRun run_program(const std::vector<std::string>& arguments);

/// The same, but the program gets `signal` as soon as `is_time` says so; status 128 + `signal` where that
/// ended it.
ProgramRun run_program_until(const std::function<bool()>& is_time, const std::vector<std::string>& arguments,
                             int signal = SIGKILL);

/// The same on a disk that is full: no file of the program may grow beyond `kilobytes`.
ProgramRun run_program_on_full_disk(int kilobytes, const std::vector<std::string>& arguments);

/// The same as a user who may not write what others own: `nobody` where the tests are run by root. Nothing
/// where the machine has no such user, or the program cannot be run by it.
std::optional<ProgramRun> run_program_as_ordinary_user(const std::vector<std::string>& arguments);

/// A disk of its own, in memory; needs a privilege that not every machine grants.
class SmallDisk {
 public:
  explicit SmallDisk(std::filesystem::path place);
  ~SmallDisk();
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  /// False where the machine does not allow it; errno says why.
  bool mount(int kilobytes) const;
  bool resize(int kilobytes) const;

 private:
  std::filesystem::path place_;
};

/// Matches a run that ended with status 0; shows what it printed otherwise.
MATCHER(Succeeded, "") {
  *result_listener << "status " << arg.status << ", error output: " << arg.error;
  return arg.status == 0;
}

/// What a run printed as errors, without the lines of progress that a slow machine adds.
std::vector<std::string> error_lines(const ProgramRun& run);

/// Matches a run that ended with status 1 and exactly one line of error that holds `part`.
MATCHER_P(FailedWith, part, "") {
  *result_listener << "status " << arg.status << ", error output: " << arg.error;
  const std::vector<std::string> lines = error_lines(arg);
  const bool is_one_line = lines.size() == 1 && arg.error.ends_with('\n');
  return arg.status == 1 && is_one_line && lines[0].find(part) != std::string::npos;
}

/// Names of what lies in a folder, hidden files included; empty where there is no such folder.
std::vector<std::string> entries_of(const std::filesystem::path& folder);

/// When each file below a folder was last written, by its path in it.
std::map<std::string, std::filesystem::file_time_type> write_times(const std::filesystem::path& folder);

}  // namespace knuckle::testing
