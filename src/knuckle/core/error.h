// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace knuckle {

/// A fault in what the caller handed over: a file, an option, a value. The message is one line for a person
/// that names the file (or value), the fault, and what was expected; the program prints it and exits with 1.
class Error : public std::runtime_error {
 public:
  /// What a file says may be part of the message. A 0 in it would end the message: it is written as \x00.
  explicit Error(std::string message) : std::runtime_error(without_zeros(std::move(message))) {}

 private:
  static std::string without_zeros(std::string message) {
    for (std::size_t at = message.find('\0'); at != std::string::npos; at = message.find('\0', at)) {
      message.replace(at, 1, "\\x00");
    }
    return message;
  }
};

/// Throws an Error with a formatted message.
template <class... Arguments>
[[noreturn]] void fail(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  throw Error(fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace knuckle
