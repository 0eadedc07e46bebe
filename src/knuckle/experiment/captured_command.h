// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace knuckle {

/// What a command left.
struct CapturedCommand {
  int status = -1;     ///< exit status; 127: it is not there; -1: a signal ended it
  std::string output;  ///< standard output and errors
};

/// Runs a command and waits for its end.
CapturedCommand run_captured(const std::vector<std::string>& words);

/// The words as a shell reads them.
std::string shell_quoted(const std::vector<std::string>& words);

}  // namespace knuckle
