// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

#include "knuckle/stream/camera_messages.h"

namespace knuckle {

/// The program that holds the libraries of cameras: libexec/knuckle/knuckle-camera of the same installation.
/// Throws an Error where it is missing.
std::filesystem::path camera_program();

/// A message that came, with its bytes.
struct ReceivedMessage {
  CameraMessage kind = CameraMessage::end;
  std::vector<std::uint8_t> bytes;
};

/// A running process that reads a camera or a recording. It ends with this object: by itself within a second,
/// or it is ended.
class CameraProcess {
 public:
  /// Starts `program`. `where` is what messages are about. Throws an Error where it cannot be started.
  CameraProcess(const std::filesystem::path& program, std::vector<std::string> arguments, std::string where);
  ~CameraProcess();
  CameraProcess(const CameraProcess&) = delete;
  CameraProcess& operator=(const CameraProcess&) = delete;

  /// The next message, if it comes as a whole within that time. Throws an Error where the process has ended
  /// (which says how), or sent what is no message.
  std::optional<ReceivedMessage> receive(std::chrono::milliseconds longest);
  /// The same, but waits for it and throws an Error where it does not come within that time, and Interrupted
  /// where the program is asked to end.
  ReceivedMessage wait_for_message(std::chrono::duration<double> longest);

 private:
  /// Reads what is there until `received_` holds so many bytes; false where that is not yet so.
  bool read_until(std::size_t bytes);
  [[noreturn]] void fail_as_ended();
  /// How it ended, once it has; nothing where it still runs after that time.
  std::optional<int> wait_for_end(std::chrono::milliseconds longest);

  std::string where_;
  pid_t process_ = 0;
  int to_ = -1;    ///< its standard input: it ends when this is closed
  int from_ = -1;  ///< its standard output
  std::vector<std::uint8_t> received_;
  std::size_t filled_ = 0;
};

}  // namespace knuckle
