// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/error.h"

#include <string>

#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::size_t kLongestMessage = 16000;  // bytes

/// One line of printable text, which no terminal takes for a command.
std::string one_line(std::string_view message) {
  return shortened(printable(shortened(message, kLongestMessage)), kLongestMessage);
}

}  // namespace

Error::Error(std::string_view message) : std::runtime_error(one_line(message)) {}

}  // namespace knuckle
