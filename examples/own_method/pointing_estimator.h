// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <knuckle/estimate/estimator.h>

namespace own {

/// A finger that points at the camera: the palm is the mean of the hand's pixels, the finger tip the nearest.
class PointingEstimator final : public knuckle::Estimator {
 public:
  knuckle::Convention convention() const override { return {"pointing2", kLandmarks}; }
  const knuckle::PatchExtractor& patches() const override { return patches_; }

  /// u and v run from -1 to 1 over the patch, d counts deviations from the hand's mean depth.
  knuckle::PatchPose estimate(const knuckle::HandPatch& patch) const override {
    const int size = patch.pixels.width();
    const double last = size - 1;
    knuckle::PatchPoint palm{0.0, 0.0, 0.0};
    knuckle::PatchPoint tip{0.0, 0.0, knuckle::kPatchBackground};
    int count = 0;
    for (int row = 0; row < size; ++row) {
      for (int column = 0; column < size; ++column) {
        const double d = patch.pixels(column, row);
        if (d >= knuckle::kPatchBackground) continue;  // not hand
        const knuckle::PatchPoint point{2.0 * column / last - 1.0, 2.0 * row / last - 1.0, d};
        palm = {palm.u + point.u, palm.v + point.v, palm.d + point.d};
        if (point.d < tip.d) tip = point;
        ++count;
      }
    }
    return {.joints = {{palm.u / count, palm.v / count, palm.d / count}, tip}, .confidence = {}};
  }

 private:
  static constexpr knuckle::Landmark kLandmarks[] = {knuckle::Landmark::palm, knuckle::Landmark::index_tip};
  knuckle::PatchExtractor patches_{{.size_px = 64}};
};

}  // namespace own
