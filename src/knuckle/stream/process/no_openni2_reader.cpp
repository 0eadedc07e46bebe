// SPDX-License-Identifier: Apache-2.0
// In place of openni2_reader.cpp where OpenNI2 is missing.
#include "knuckle/core/error.h"
#include "knuckle/stream/process/camera_readers.h"

namespace knuckle {
namespace {

constexpr const char* kNoOpenni2 = "this build lacks OpenNI2 (libopenni2-dev)";

}  // namespace

void list_openni2(const Program&) {
  fail("{}", kNoOpenni2);
}

void read_openni2(const Program&, const std::string&, int, int, int) {
  fail("{}", kNoOpenni2);
}

void read_oni(const Program&, const std::string&) {
  fail("{}", kNoOpenni2);
}

}  // namespace knuckle
