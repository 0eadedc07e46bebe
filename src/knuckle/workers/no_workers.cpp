// SPDX-License-Identifier: Apache-2.0
// In place of join_workers.cpp where Gloo's headers were not there to build with.
#include "knuckle/core/error.h"
#include "knuckle/workers/join_workers.h"

namespace knuckle {

bool has_workers() {
  return false;
}

std::unique_ptr<JoinedWorkers> join_workers(const JoinOptions& /*options*/) {
  fail("--workers: this program was built without Gloo: install libgloo-dev and build it again");
}

}  // namespace knuckle
