// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/frame.h"

namespace knuckle {
namespace {

HandSide other_side(HandSide side) {
  return side == HandSide::left ? HandSide::right : HandSide::left;
}

}  // namespace

HandTruth mirrored(const HandTruth& hand, int width) {
  return {other_side(hand.side), mirrored(hand.pose, width), hand.occluders, hand.visible_share};
}

Frame mirrored(const Frame& frame) {
  Frame result;
  result.name = frame.name;
  result.camera = mirrored(frame.camera);
  result.depth_mm = mirrored(frame.depth_mm);
  result.infrared = mirrored(frame.infrared);
  result.mask = mirrored(frame.mask);
  if (frame.truth) result.truth = mirrored(*frame.truth, frame.camera.width);
  if (frame.side) result.side = other_side(*frame.side);
  result.labels = mirrored(frame.labels);
  for (const HandTruth& hand : frame.hands) result.hands.push_back(mirrored(hand, frame.camera.width));
  result.time_s = frame.time_s;
  result.sequence = frame.sequence;
  return result;
}

}  // namespace knuckle
