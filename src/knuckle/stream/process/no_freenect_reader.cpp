// SPDX-License-Identifier: Apache-2.0
// In place of freenect_reader.cpp where libfreenect is missing.
#include "knuckle/core/error.h"
#include "knuckle/stream/process/camera_readers.h"

namespace knuckle {
namespace {

constexpr const char* kNoFreenect = "this build lacks libfreenect (libfreenect-dev)";

}  // namespace

void list_freenect(const Program&) {
  fail("{}", kNoFreenect);
}

void read_freenect(const Program&, int, bool) {
  fail("{}", kNoFreenect);
}

}  // namespace knuckle
