// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace knuckle {

/// The largest count below `too_many` for which `fits(count)` holds, where that holds for all smaller ones;
/// 0 where it holds for none.
template <class Fits>
std::int64_t most_that_fit(std::int64_t too_many, const Fits& fits) {
  std::int64_t fitting = 0;
  while (too_many - fitting > 1) {
    const std::int64_t middle = fitting + (too_many - fitting) / 2;
    (fits(middle) ? fitting : too_many) = middle;
  }
  return fitting;
}

}  // namespace knuckle
