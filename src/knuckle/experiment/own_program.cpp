// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/own_program.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr const char* kOwnProgram = "/proc/self/exe";
constexpr std::string_view kPrefix = "knuckle: ";  // of the program's error lines
constexpr int kNotStarted = 127;

void print(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
}

/// What the child does between fork and exec, where only calls that are safe in signal handlers may stand.
[[noreturn]] void become(pid_t parent, int error_output, const char* program, char* const* words) {
  // Whatever ends the parent, even SIGKILL, ends the child.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() == parent && ::dup2(error_output, STDERR_FILENO) >= 0) ::execvp(program, words);
  ::_exit(kNotStarted);
}

/// What a process said last on its error output.
struct LastWords {
  std::string fault;  ///< its error line; empty: none
  std::string line;   ///< the last line that is none
};

/// A run of our own program whose error output we read.
class Child {
 public:
  /// `words` is the command line, `program` what is started by it.
  Child(const std::string& program, std::vector<std::string> words) {
    std::vector<char*> pointers;
    for (std::string& word : words) pointers.push_back(word.data());
    pointers.push_back(nullptr);
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("cannot make a pipe: {}", std::strerror(errno));
    const pid_t parent = ::getpid();
    std::fflush(nullptr);  // what we print stands before what the child prints
    process_ = ::fork();
    if (process_ == 0) become(parent, ends[1], program.c_str(), pointers.data());
    const int fault = errno;
    ::close(ends[1]);
    error_output_ = ends[0];
    if (process_ > 0) return;
    ::close(error_output_);
    fail("cannot start a process: {}", std::strerror(fault));
  }

  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  ~Child() {
    ::close(error_output_);
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    wait();
  }

  /// Passes on its error output, all but the last words, which it returns, until it closes it.
  LastWords pass_on_errors() {
    LastWords last;
    std::string kept;
    std::array<char, 4096> block{};
    for (;;) {
      wait_for_output();
      const ssize_t length = ::read(error_output_, block.data(), block.size());
      if (length < 0 && errno == EINTR) continue;
      if (length <= 0) break;
      kept.append(block.data(), static_cast<std::size_t>(length));
      for (std::size_t end = kept.find('\n'); end != std::string::npos; end = kept.find('\n')) {
        take(kept.substr(0, end + 1), last);
        kept.erase(0, end + 1);
      }
    }
    if (!kept.empty()) take(kept, last);
    return last;
  }

  /// Its status as `waitpid` tells it.
  int wait() {
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    return status;
  }

 private:
  /// Until there is something to read, or the end. Where we are asked to end and the child was not (Ctrl-C in
  /// a terminal reaches both), it is asked after a while.
  void wait_for_output() {
    constexpr int kLookMs = 100;
    constexpr int kGraceMs = 3000;
    pollfd output{error_output_, POLLIN, 0};
    while (::poll(&output, 1, kLookMs) <= 0) {
      if (!is_interrupted() || asked_to_end_) continue;
      waited_ms_ += kLookMs;
      if (waited_ms_ < kGraceMs) continue;
      ::kill(process_, SIGTERM);
      asked_to_end_ = true;
    }
  }

  /// Who started the program may say something after its error line, as srun does.
  static void take(std::string line, LastWords& last) {
    if (line.starts_with(kPrefix)) {
      last.fault = std::move(line);
      return;
    }
    print(last.line);
    last.line = std::move(line);
  }

  pid_t process_ = 0;
  int error_output_ = -1;
  int waited_ms_ = 0;
  bool asked_to_end_ = false;
};

}  // namespace

std::string own_program_file() {
  std::error_code unknown;
  const std::filesystem::path file = std::filesystem::read_symlink(kOwnProgram, unknown);
  if (unknown) fail("cannot find the program's own file: {}", unknown.message());
  return file.string();
}

void run_own_program(const std::vector<std::string>& arguments, const std::vector<std::string>& starter) {
  std::vector<std::string> words = starter;
  words.push_back(starter.empty() ? "knuckle" : own_program_file());
  words.insert(words.end(), arguments.begin(), arguments.end());
  Child child(starter.empty() ? kOwnProgram : starter.front(), words);
  const LastWords last = child.pass_on_errors();
  const int status = child.wait();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    print(last.line);
    print(last.fault);
    return;
  }
  end_if_interrupted();  // then it ended because it was asked to, as we are
  const std::string command = "knuckle " + joined(arguments, " ");
  if (WIFSIGNALED(status)) fail("`{}` was ended by signal {}", command, WTERMSIG(status));
  if (WEXITSTATUS(status) == kNotStarted) fail("`{}` could not be started", command);
  if (!last.fault.empty()) {
    print(last.line);
    fail("{}", trimmed(std::string_view(last.fault).substr(kPrefix.size())));
  }
  const std::string_view message = trimmed(last.line);
  if (message.empty()) fail("`{}` failed without a word", command);
  fail("{}", message);
}

}  // namespace knuckle
