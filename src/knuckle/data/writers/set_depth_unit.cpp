// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/writers/set_depth_unit.h"

#include <array>
#include <atomic>

#include "knuckle/core/parallel.h"
#include "knuckle/data/readers/depth_image.h"

namespace knuckle {

double set_depth_unit_mm(const FrameSource& source) {
  std::array<std::atomic<bool>, kDepthUnitsMm.size()> is_inexact{};
  std::atomic<bool> is_far = false;
  parallel_for(source.size(), [&](std::int64_t i) {
    const Image<float> depth_mm = source.read(i).depth_mm;
    for (std::size_t unit = 0; unit < kDepthUnitsMm.size(); ++unit) {
      if (!is_inexact[unit] && !is_exact_in(depth_mm, kDepthUnitsMm[unit])) is_inexact[unit] = true;
    }
    if (!reaches_all(depth_mm, kDepthUnitsMm.back())) is_far = true;
  });
  for (std::size_t unit = 0; unit < kDepthUnitsMm.size(); ++unit) {
    if (!is_inexact[unit]) return kDepthUnitsMm[unit];
  }
  return is_far ? kDepthUnitsMm.front() : kDepthUnitsMm.back();
}

}  // namespace knuckle
