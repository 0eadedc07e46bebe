// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/camera_process.h"

#include <cerrno>
#include <csignal>
#include <cstring>
#include <system_error>
#include <thread>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/resources.h"

extern char** environ;

namespace knuckle {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Both ends of a pipe; what is not taken is closed.
class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_, O_CLOEXEC) != 0) fail("no pipe: {}", std::generic_category().message(errno));
  }
  ~Pipe() {
    for (const int end : ends_) {
      if (end >= 0) ::close(end);
    }
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int reading() const { return ends_[0]; }
  int writing() const { return ends_[1]; }
  int take_reading() { return std::exchange(ends_[0], -1); }
  int take_writing() { return std::exchange(ends_[1], -1); }

 private:
  int ends_[2] = {-1, -1};
};

std::string how_it_ended(int status) {
  if (WIFSIGNALED(status)) return fmt::format("crashed ({})", ::strsignal(WTERMSIG(status)));
  return fmt::format("ended too early (status {})", WEXITSTATUS(status));
}

/// Waits until a descriptor can be read, or is closed, for so long at most.
bool wait_until_readable(int descriptor, milliseconds longest) {
  pollfd waiting{descriptor, POLLIN, 0};
  return ::poll(&waiting, 1, static_cast<int>(longest.count())) > 0;
}

}  // namespace

std::filesystem::path camera_program() {
  return helper_program("knuckle-camera");
}

CameraProcess::CameraProcess(const std::filesystem::path& program, std::vector<std::string> arguments,
                             std::string where)
    : where_(std::move(where)) {
  Pipe in;
  Pipe out;
  std::string name = program.string();
  std::vector<char*> pointers{name.data()};
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, in.reading(), 0);
  ::posix_spawn_file_actions_adddup2(&actions, out.writing(), 1);
  ::posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  const int fault = ::posix_spawn(&process_, name.c_str(), &actions, nullptr, pointers.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (fault != 0) fail("{}: cannot be started: {}", name, std::generic_category().message(fault));
  to_ = in.take_writing();
  from_ = out.take_reading();
  ::fcntl(from_, F_SETFL, O_NONBLOCK);
}

CameraProcess::~CameraProcess() {
  ::close(to_);
  ::close(from_);
  if (process_ == 0 || wait_for_end(milliseconds(1000))) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

std::optional<int> CameraProcess::wait_for_end(milliseconds longest) {
  const auto end = Clock::now() + longest;
  while (true) {
    int status = 0;
    if (::waitpid(process_, &status, WNOHANG) == process_) {
      process_ = 0;
      return status;
    }
    if (Clock::now() >= end) return std::nullopt;
    std::this_thread::sleep_for(milliseconds(1));
  }
}

void CameraProcess::fail_as_ended() {
  if (process_ == 0) fail("{}: the process that reads it has ended", where_);
  const std::optional<int> status = wait_for_end(milliseconds(1000));
  fail("{}: the process that reads it {}", where_, status ? how_it_ended(*status) : "sends nothing any more");
}

bool CameraProcess::read_until(std::size_t bytes) {
  if (received_.size() < bytes) received_.resize(bytes);
  while (filled_ < bytes) {
    const ssize_t count = ::read(from_, received_.data() + filled_, bytes - filled_);
    if (count == 0) fail_as_ended();
    if (count < 0 && (errno == EAGAIN || errno == EINTR)) return false;
    if (count < 0) fail("{}: cannot be read: {}", where_, std::generic_category().message(errno));
    filled_ += static_cast<std::size_t>(count);
  }
  return true;
}

std::optional<ReceivedMessage> CameraProcess::receive(milliseconds longest) {
  const auto end = Clock::now() + longest;
  while (true) {
    if (read_until(sizeof(CameraMessageHead))) {
      CameraMessageHead head;
      std::memcpy(&head, received_.data(), sizeof head);
      check(head, where_);
      if (read_until(sizeof head + head.bytes)) {
        received_.resize(sizeof head + head.bytes);
        received_.erase(received_.begin(), received_.begin() + sizeof head);
        filled_ = 0;
        return ReceivedMessage{static_cast<CameraMessage>(head.kind), std::exchange(received_, {})};
      }
    }
    const auto left = std::chrono::ceil<milliseconds>(end - Clock::now());
    if (left.count() <= 0) return std::nullopt;
    wait_until_readable(from_, left);
  }
}

ReceivedMessage CameraProcess::wait_for_message(std::chrono::duration<double> longest) {
  constexpr milliseconds kLongestWait{50};  // until Ctrl-C is looked at
  const auto begin = Clock::now();
  while (true) {
    end_if_interrupted();
    if (auto message = receive(kLongestWait)) return *std::move(message);
    if (Clock::now() - begin >= longest) fail("{}: gave no answer for {:g} s", where_, longest.count());
  }
}

}  // namespace knuckle
