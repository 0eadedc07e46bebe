// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/record_of.h"

#include "knuckle/camera/projection.h"

namespace knuckle {

FrameRecord record_of(const FrameResult& result, PixelOrigin origin) {
  FrameRecord record;
  record.frame = result.index;
  record.name = result.name;
  record.time_s = result.time_s;
  record.status = result.estimate.status;
  if (result.estimate.hands.empty()) return record;
  const Projection projection(result.camera);
  for (const HandEstimate& estimate : result.estimate.hands) {
    HandRecord hand = hand_record(estimate.pose, projection, origin);
    hand.id = static_cast<int>(record.hands.size()) + 1;
    hand.side = estimate.side;
    hand.score = estimate.score;
    record.hands.push_back(std::move(hand));
  }
  return record;
}

}  // namespace knuckle
