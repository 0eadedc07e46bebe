// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/exact_frame.h"

namespace knuckle {

ExactFrame mirrored(const ExactFrame& frame) {
  const int width = frame.mask.width();
  ExactFrame result;
  result.surfaces = {mirrored(frame.surfaces.depth_mm), mirrored(frame.surfaces.cosines)};
  result.mask = mirrored(frame.mask);
  result.truth = mirrored(frame.truth, width);
  result.labels = mirrored(frame.labels);
  for (const HandTruth& hand : frame.hands) result.hands.push_back(mirrored(hand, width));
  return result;
}

}  // namespace knuckle
