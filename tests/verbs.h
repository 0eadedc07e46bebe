// SPDX-License-Identifier: Apache-2.0
// What the tests of single verbs share.
#pragma once

#include "program.h"

#include <string>

namespace knuckle::testing {

/// Six frames of the demonstration.
inline constexpr const char* kSixFrames = "synthetic:manifests/demo.toml?count=6";

/// A verb runs in the repository's folder, and what it writes goes into a temporary one.
class VerbsTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }

  TemporaryFolder folder_;
};

}  // namespace knuckle::testing
