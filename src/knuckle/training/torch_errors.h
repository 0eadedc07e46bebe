// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <string>

#include <c10/util/Exception.h>

#include "knuckle/core/error.h"

namespace knuckle {

/// LibTorch's messages run over many lines; the first one says what is wrong.
inline std::string first_line(const c10::Error& error) {
  const std::string text = error.what_without_backtrace();
  return text.substr(0, text.find('\n'));
}

/// Returns what `work` returns. An exception of LibTorch becomes an Error of one line that starts with
/// `what`.
template <class Work>
auto with_clear_errors(const std::string& what, const Work& work) {
  try {
    return work();
  } catch (const c10::Error& error) {
    fail("{}: {}", what, first_line(error));
  }
}

}  // namespace knuckle
