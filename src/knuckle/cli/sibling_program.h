// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace knuckle::cli {

/// Goes on as another program that lies beside this one, with the same command line. Throws an Error where it
/// is not there or cannot be started.
[[noreturn]] void become_sibling(const std::string& program);

}  // namespace knuckle::cli
