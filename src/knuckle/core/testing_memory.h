// SPDX-License-Identifier: Apache-2.0
// For tests only; not part of the library.
#pragma once

#include <sys/resource.h>

namespace knuckle::testing {

/// The most memory that this process has had so far [kB].
inline long peak_memory_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

}  // namespace knuckle::testing
