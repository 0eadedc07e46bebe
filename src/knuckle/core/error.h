// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace knuckle {

/// A fault in what the caller handed over: a file, an option, a value. The message is one line for a person
/// that names the file (or value), the fault, and what was expected; the program prints it and exits with 1.
class Error : public std::runtime_error {
 public:
  /// A message may quote what a file holds: what a terminal would not show as it is becomes \\n, \\xNN or
  /// \\u{NNNN} (`printable`), and a message ends after 16,000 bytes.
  explicit Error(std::string_view message);
};

/// Throws an Error with a formatted message.
template <class... Arguments>
[[noreturn]] void fail(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  throw Error(fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace knuckle
