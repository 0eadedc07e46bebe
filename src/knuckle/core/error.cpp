// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/error.h"

#include <string>

#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::size_t kLongestMessage = 16000;  // bytes

/// Its front, with no part of a character at the end.
std::string_view shortened(std::string_view text) {
  if (text.size() <= kLongestMessage) return text;
  std::size_t end = kLongestMessage;
  while (end > 0 && (text[end] & 0xC0) == 0x80) --end;  // inside a character of UTF-8
  return text.substr(0, end);
}

/// One line of printable text, which no terminal takes for a command.
std::string one_line(std::string_view message) {
  std::string shown = printable(shortened(message));
  if (message.size() <= kLongestMessage && shown.size() <= kLongestMessage) return shown;
  return std::string(shortened(shown)) + "...";
}

}  // namespace

Error::Error(std::string_view message) : std::runtime_error(one_line(message)) {}

}  // namespace knuckle
