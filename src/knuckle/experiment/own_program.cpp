// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/own_program.h"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string_view>

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

/// What the child does between fork and exec, where only calls that are safe in signal handlers may stand.
[[noreturn]] void become(pid_t parent, int error_output, char* const* arguments) {
  // Whatever ends the parent, even SIGKILL, ends the child.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() == parent && ::dup2(error_output, STDERR_FILENO) >= 0) ::execv(kOwnProgram, arguments);
  ::_exit(kNotStarted);
}

/// A run of our own program whose error output we read.
class Child {
 public:
  explicit Child(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "knuckle");
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail("cannot make a pipe: {}", std::strerror(errno));
    const pid_t parent = ::getpid();
    std::fflush(nullptr);  // what we print stands before what the child prints
    process_ = ::fork();
    if (process_ == 0) become(parent, ends[1], pointers.data());
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

  /// Passes on its error output, all but the last line, which it returns, until it closes it.
  std::string pass_on_errors() {
    std::string kept;
    std::array<char, 4096> block{};
    for (;;) {
      wait_for_output();
      const ssize_t length = ::read(error_output_, block.data(), block.size());
      if (length < 0 && errno == EINTR) continue;
      if (length <= 0) return kept;
      kept.append(block.data(), static_cast<std::size_t>(length));
      const std::size_t last_line = start_of_last_line(kept);
      std::fwrite(kept.data(), 1, last_line, stderr);
      kept.erase(0, last_line);
    }
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

  /// Behind the last line end but one that ends the text.
  static std::size_t start_of_last_line(const std::string& text) {
    if (text.size() < 2) return 0;
    const std::size_t end = text.rfind('\n', text.size() - 2);
    return end == std::string::npos ? 0 : end + 1;
  }

  pid_t process_ = 0;
  int error_output_ = -1;
  int waited_ms_ = 0;
  bool asked_to_end_ = false;
};

}  // namespace

void run_own_program(const std::vector<std::string>& arguments) {
  Child child(arguments);
  const std::string last_line = child.pass_on_errors();
  const int status = child.wait();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
    std::fwrite(last_line.data(), 1, last_line.size(), stderr);
    return;
  }
  end_if_interrupted();  // then it ended because it was asked to, as we are
  const std::string command = "knuckle " + joined(arguments, " ");
  if (WIFSIGNALED(status)) fail("`{}` was ended by signal {}", command, WTERMSIG(status));
  if (WEXITSTATUS(status) == kNotStarted) fail("`{}` could not be started", command);
  std::string_view message = trimmed(last_line);
  if (message.starts_with(kPrefix)) message.remove_prefix(kPrefix.size());
  if (message.empty()) fail("`{}` failed without a word", command);
  fail("{}", message);
}

}  // namespace knuckle
