// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/pictures/gnuplot.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/eval/pictures/scratch_folder.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

constexpr int kCommandNotFound = 127;  // what a spawned child reports where its program cannot be started

[[noreturn]] void fail_missing() {
  fail("gnuplot: not found; the figures need it (Debian: apt-get install gnuplot-nox)");
}

/// Starts gnuplot with its messages going to a file; its exit status.
int spawn_gnuplot(const std::filesystem::path& script, const std::filesystem::path& messages) {
  std::string name = "gnuplot";
  std::string no_user_settings = "-d";
  std::string script_name = script.string();
  const std::array<char*, 4> arguments = {name.data(), no_user_settings.data(), script_name.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t child = 0;
  const int fault = ::posix_spawnp(&child, name.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (fault == ENOENT) fail_missing();
  if (fault != 0) fail("gnuplot: cannot be started: {}", std::generic_category().message(fault));
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail("gnuplot: lost: {}", std::generic_category().message(errno));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// The last line that says something: where gnuplot states the fault, below the command and a marker.
std::string complaint_in(const std::filesystem::path& messages) {
  std::string complaint = "it gave no reason";
  for (const std::string& line : read_lines(messages)) {
    if (!trimmed(line).empty()) complaint = trimmed(line);
  }
  return complaint;
}

}  // namespace

void run_gnuplot(std::string_view script) {
  const ScratchFolder folder;
  const std::filesystem::path script_file = folder.path() / "script.gp";
  const std::filesystem::path messages = folder.path() / "messages.txt";
  write_text_file(script_file, script);
  const int status = spawn_gnuplot(script_file, messages);
  if (status == kCommandNotFound) fail_missing();
  if (status != 0) fail("gnuplot: {}", complaint_in(messages));
}

std::string gnuplot_quoted(std::string_view text) {
  // Single quotes would need doubling, which gnuplot does not understand everywhere (as a string's first
  // character).
  constexpr std::string_view kPlain = " _-+.,:;/()=<>%&";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool is_letter = (byte | 0x20) >= 'a' && (byte | 0x20) <= 'z';
    const bool is_digit = byte >= '0' && byte <= '9';
    if (byte < 0x20 || byte == 0x7f) {
      quoted += ' ';
    } else if (is_letter || is_digit || byte >= 0x80 || kPlain.find(c) != std::string_view::npos) {
      quoted += c;
    } else {
      quoted += fmt::format("\\{:03o}", byte);
    }
  }
  return quoted + '"';
}

}  // namespace knuckle
