// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/start.h"

#include "knuckle/core/error.h"
#include "knuckle/pipeline/hand_finder.h"

namespace knuckle {

Start start_from_name(std::string_view name) {
  if (name == "nearest") return Start::nearest;
  if (name == "truth") return Start::truth;
  fail("start is '{}', expected nearest or truth", name);
}

std::optional<Point3> start_in(const Frame& frame, Start start) {
  return start == Start::truth ? true_start(frame) : std::nullopt;
}

void require_start(const FrameSource& source, Start start, std::string_view source_name) {
  if (start == Start::truth && !source.convention()) {
    fail("{}: segmentation was to start at the truth, but the source has none", source_name);
  }
}

}  // namespace knuckle
