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
    hand.id = estimate.id > 0 ? estimate.id : static_cast<int>(record.hands.size()) + 1;
    hand.side = estimate.side;
    hand.score = estimate.score;
    hand.skeleton = estimate.skeleton;
    for (int i = 0; estimate.angles && i < kHandAngleCount; ++i) {
      const auto angle = static_cast<HandAngle>(i);
      hand.angles_rad.emplace_back(name_of(angle), (*estimate.angles)[angle]);
    }
    record.hands.push_back(std::move(hand));
  }
  return record;
}

}  // namespace knuckle
