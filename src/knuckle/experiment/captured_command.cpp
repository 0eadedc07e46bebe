// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/captured_command.h"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <sys/wait.h>

#include "knuckle/core/error.h"

namespace knuckle {

CapturedCommand run_captured(const std::vector<std::string>& words) {
  std::fflush(nullptr);
  std::FILE* const output = ::popen((shell_quoted(words) + " 2>&1 </dev/null").c_str(), "re");
  if (output == nullptr) fail("{}: cannot be started: {}", words.front(), std::strerror(errno));
  CapturedCommand captured;
  std::array<char, 4096> block{};
  while (const std::size_t length = std::fread(block.data(), 1, block.size(), output)) {
    captured.output.append(block.data(), length);
  }
  const int status = ::pclose(output);
  captured.status = status >= 0 && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return captured;
}

std::string shell_quoted(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) {
    text += text.empty() ? "'" : " '";
    for (const char character : word) {
      if (character == '\'') {
        text += "'\\''";
      } else {
        text += character;
      }
    }
    text += "'";
  }
  return text;
}

}  // namespace knuckle
