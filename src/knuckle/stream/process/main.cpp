// SPDX-License-Identifier: Apache-2.0
// knuckle-camera: holds the libraries of cameras for the program `knuckle`, which starts it and reads
// messages (camera_messages.h) from its standard output. It ends when its standard input is closed.
//
//   knuckle-camera list freenect|openni2
//   knuckle-camera freenect INDEX raw|mm
//   knuckle-camera openni2 URI WIDTH HEIGHT RATE
//   knuckle-camera oni FILE
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/stream/process/camera_readers.h"

namespace knuckle {
namespace {

/// Whether the other end of standard input is closed, after this many milliseconds at most; -1: any time.
bool is_input_closed(int longest_ms) {
  pollfd waiting{STDIN_FILENO, 0, 0};
  return ::poll(&waiting, 1, longest_ms) > 0 && (waiting.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
}

/// Ends a process that a library does not let go of.
void end_after_input() {
  std::thread([] {
    while (!is_input_closed(-1)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    ::_exit(0);
  }).detach();
}

/// Libraries print: their words go nowhere, and messages have a descriptor of their own.
int take_output() {
  const int messages = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  return messages;
}

/// A damaged file may ask for anything. (The sanitizers take most of a machine's addresses for themselves.)
void limit_what_a_file_can_do() {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  constexpr rlim_t kMostMemory = rlim_t{900} << 20;  // recordings of 640 x 480 take less than 400 MB
  const rlimit memory{kMostMemory, kMostMemory};
  ::setrlimit(RLIMIT_AS, &memory);
#endif
  std::signal(SIGXFSZ, SIG_IGN);  // writing fails, in place of ending us
  const rlimit no_files{0, 0};
  ::setrlimit(RLIMIT_FSIZE, &no_files);
  ::setrlimit(RLIMIT_CORE, &no_files);
}

void run(const Program& program, const std::vector<std::string>& arguments) {
  const std::string verb = arguments.empty() ? "" : arguments[0];
  if (verb == "list" && arguments.size() == 2) {
    arguments[1] == "freenect" ? list_freenect(program) : list_openni2(program);
    program.send_end();
  } else if (verb == "freenect" && arguments.size() == 3) {
    read_freenect(program, std::atoi(arguments[1].c_str()), arguments[2] == "mm");
  } else if (verb == "openni2" && arguments.size() == 5) {
    read_openni2(program, arguments[1], std::atoi(arguments[2].c_str()), std::atoi(arguments[3].c_str()),
                 std::atoi(arguments[4].c_str()));
  } else if (verb == "oni" && arguments.size() == 2) {
    limit_what_a_file_can_do();
    read_oni(program, arguments[1]);
  } else {
    fail(
        "knuckle-camera was called with arguments that it does not know; it belongs to another version of "
        "Knuckle");
  }
}

/// Nobody reads any more: there is nothing left to do.
void end_unless(bool is_written) {
  if (!is_written) ::_exit(0);
}

}  // namespace

void Program::send(const PipedDescription& description) const {
  end_unless(put_message(descriptor_, CameraMessage::description, bytes_of(description)));
}

void Program::send(const PipedFrame& frame, std::span<const std::uint8_t> pixels) const {
  end_unless(put_message(descriptor_, CameraMessage::frame, bytes_of(frame), pixels));
}

void Program::send_listing(const std::string& device, const std::string& name) const {
  end_unless(put_text(descriptor_, CameraMessage::listing, device + '\n' + name));
}

void Program::send_fault(const std::string& text) const {
  end_unless(put_text(descriptor_, CameraMessage::fault, text));
}

void Program::send_end() const {
  end_unless(put_message(descriptor_, CameraMessage::end));
}

bool Program::is_gone() const {
  return is_input_closed(0);
}

}  // namespace knuckle

int main(int count, char** arguments) {
  const knuckle::Program program(knuckle::take_output());
  std::signal(SIGINT, SIG_IGN);   // Ctrl-C is for the program that reads us, which closes our input
  std::signal(SIGPIPE, SIG_IGN);  // writing fails then
  knuckle::end_after_input();
  int status = 0;
  try {
    knuckle::run(program, {arguments + 1, arguments + count});
  } catch (const std::exception& error) {
    program.send_fault(error.what());
    status = 1;
  }
  ::_exit(status);  // libraries that crash at their end are not asked to
}
