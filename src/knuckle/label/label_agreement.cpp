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

double overlap_of(const LabelMask& one, const LabelMask& other, HandKey hand) {
  if (one.width != other.width || one.height != other.height) {
    fail("frame {}: masks of {}x{} and of {}x{} pixels cannot be compared", hand.frame, one.width, one.height,
         other.width, other.height);
  }
  const Image<std::uint8_t> a = pixels_of(one);
  const Image<std::uint8_t> b = pixels_of(other);
  std::int64_t in_both = 0;
  std::int64_t in_any = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    in_both += a.data()[i] != 0 && b.data()[i] != 0 ? 1 : 0;
    in_any += a.data()[i] != 0 || b.data()[i] != 0 ? 1 : 0;
  }
  return in_any == 0 ? 1.0 : static_cast<double>(in_both) / static_cast<double>(in_any);
}

/// Adds the hand to what is known of its landmarks.
HandAgreement compared(HandKey hand, const LabelChange& one, const LabelChange& other,
                       const Projection& projection, LabelAgreement& agreement) {
  LandmarkAgreement of_hand;
  for (std::size_t i = 0; i < agreement.landmarks.size(); ++i) {
    const LandmarkLabel& a = one.landmarks[i];
    const LandmarkLabel& b = other.landmarks[i];
    if (a.at.is_missing() || b.at.is_missing()) continue;
    const double distance_mm = (projection.to_camera(a.at) - projection.to_camera(b.at)).norm();
    for (LandmarkAgreement* const of : {&agreement.landmarks[i], &agreement.all, &of_hand})
      add(*of, distance_mm, a.is_visible != b.is_visible);
  }
  return {.hand = hand,
          .landmarks = of_hand.hands,
          .mean_mm = of_hand.mean_mm,
          .largest_mm = of_hand.largest_mm,
          .mask_iou = one.mask && other.mask ? overlap_of(*one.mask, *other.mask, hand) : kNaN};
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
    agreement.each.push_back(
        compared(hand, history.newest(), of_other->newest(), Projection(camera_of(hand.frame)), agreement));
  }
  return agreement;
}

}  // namespace knuckle
