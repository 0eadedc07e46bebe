// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/label/label_book.h"

namespace knuckle {

/// How long one author worked on frames, by the page's timer.
struct LabelTimes {
  std::int64_t frames = 0;       ///< in which a person did anything
  double median_s = kNaN;        ///< per frame, both hands together
  double percentile90_s = kNaN;  ///< 9 of 10 frames took no longer
  double total_s = 0.0;
};

/// Of all frames of a book, whatever their state.
LabelTimes times_of(const LabelBook& book);

}  // namespace knuckle
