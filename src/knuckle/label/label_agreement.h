// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "knuckle/label/label_book.h"

namespace knuckle {

/// How far two authors' labels of one landmark are apart.
struct LandmarkAgreement {
  std::int64_t hands = 0;  ///< that both have labelled
  double mean_mm = kNaN;
  double largest_mm = kNaN;
  std::int64_t of_other_visibility = 0;  ///< hands that one calls visible, the other hidden
};

/// How far two authors' labels of one hand are apart.
struct HandAgreement {
  HandKey hand;
  std::int64_t landmarks = 0;  ///< that both have labelled
  double mean_mm = kNaN;
  double largest_mm = kNaN;
  double mask_iou = kNaN;  ///< pixels in both masks, of those in any, [0, 1]; NaN where one has none
};

/// How far two authors' labels of the same source are apart.
struct LabelAgreement {
  std::int64_t hands = 0;                    ///< that both have labelled, at least as sure as was asked for
  std::vector<LandmarkAgreement> landmarks;  ///< one per landmark of the convention
  LandmarkAgreement all;
  std::vector<HandAgreement> each;  ///< one per hand, by frame
};

/// Compares hands of which both labels are at least in the state `least`. Distances are in camera coordinates
/// by the cameras of the frames, which `camera_of` gives. Throws an Error where the labels are of sources of
/// different length, or of different conventions, or masks of a hand are of images of different size.
LabelAgreement agreement_of(const LabelBook& one, const LabelBook& other, LabelState least,
                            const std::function<Camera(std::int64_t frame)>& camera_of);

}  // namespace knuckle
