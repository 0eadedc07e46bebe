// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_agreement.h"

#include <algorithm>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"

namespace knuckle {
namespace {

void add(LandmarkAgreement& agreement, double distance_mm, bool is_of_other_visibility) {
  ++agreement.hands;
  const bool is_first = agreement.hands == 1;
  const double before = is_first ? 0.0 : agreement.mean_mm;
  agreement.mean_mm = before + (distance_mm - before) / static_cast<double>(agreement.hands);
  agreement.largest_mm = is_first ? distance_mm : std::max(agreement.largest_mm, distance_mm);
  agreement.of_other_visibility += is_of_other_visibility ? 1 : 0;
}

}  // namespace

LabelAgreement agreement_of(const LabelBook& one, const LabelBook& other, LabelState least,
                            const std::function<Camera(std::int64_t frame)>& camera_of) {
  if (one.head().frames != other.head().frames || !(one.head().convention == other.head().convention)) {
    fail("labels of {} frames in {} cannot be compared with those of {} frames in {}", one.head().frames,
         one.head().convention.name, other.head().frames, other.head().convention.name);
  }
  LabelAgreement agreement;
  agreement.landmarks.resize(one.head().convention.landmarks.size());
  for (const auto& [hand, history] : one.hands()) {
    const HandHistory* const of_other = other.find(hand);
    if (of_other == nullptr || history.state() < least || of_other->state() < least) continue;
    ++agreement.hands;
    const Projection projection(camera_of(hand.frame));
    for (std::size_t i = 0; i < agreement.landmarks.size(); ++i) {
      const LandmarkLabel& a = history.newest().landmarks[i];
      const LandmarkLabel& b = of_other->newest().landmarks[i];
      if (a.at.is_missing() || b.at.is_missing()) continue;
      const double distance_mm = (projection.to_camera(a.at) - projection.to_camera(b.at)).norm();
      add(agreement.landmarks[i], distance_mm, a.is_visible != b.is_visible);
      add(agreement.all, distance_mm, a.is_visible != b.is_visible);
    }
  }
  return agreement;
}

}  // namespace knuckle
