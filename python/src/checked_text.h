// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle::python {

/// The text itself. Throws an Error, which calls it `what`, where it has a zero byte: there names of files
/// would end, and messages about it.
inline const std::string& checked_text(const std::string& text, std::string_view what) {
  if (text.find('\0') != std::string::npos) fail("{}: '{}' has a zero byte", what, printable(text));
  return text;
}

}  // namespace knuckle::python
