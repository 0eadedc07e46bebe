// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/frame.h"

namespace knuckle {

Frame mirrored(const Frame& frame) {
  Frame result;
  result.name = frame.name;
  result.camera = mirrored(frame.camera);
  result.depth_mm = mirrored(frame.depth_mm);
  result.infrared = mirrored(frame.infrared);
  result.mask = mirrored(frame.mask);
  if (frame.truth) result.truth = mirrored(*frame.truth, frame.camera.width);
  if (frame.side) result.side = *frame.side == HandSide::left ? HandSide::right : HandSide::left;
  result.time_s = frame.time_s;
  result.sequence = frame.sequence;
  return result;
}

}  // namespace knuckle
