// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/stump.h"

#include <algorithm>
#include <cmath>

#include "knuckle/synth/scene/sampling.h"

namespace knuckle {

using Eigen::Vector3f;

Stump sampled_stump(Random& random) {
  Stump stump;
  stump.from_mm = between(random, 0, 150);
  stump.depth_mm = random.uniform() < 0.5 ? between(random, 0, 40) : 0.0f;
  return stump;
}

void end_in_stump(std::span<Vector3f> limb, std::span<const float> along_mm, const Stump& stump,
                  const Vector3f& wrist, const Vector3f& elbow) {
  constexpr float kWidestMm = 60.0f;  // no forearm's radius is larger; a hand's thumb is farther out
  const Vector3f to_elbow = (elbow - wrist).normalized();
  const Vector3f end = wrist + stump.from_mm * to_elbow;
  for (std::size_t i = 0; i < along_mm.size(); ++i) {
    const float beyond = stump.from_mm - along_mm[i];
    if (beyond <= 0.0f) continue;
    // Of a cap's quarter circle, from its rim, 0, to its tip, 1: farther skin lies nearer to the tip.
    const float way = std::min(beyond / std::max(stump.depth_mm, 1.0f), 1.0f);
    const Vector3f from_end = limb[i] - end;
    const Vector3f outwards = from_end - from_end.dot(to_elbow) * to_elbow;
    const float radius = std::min(outwards.norm(), kWidestMm);
    limb[i] = end - way * stump.depth_mm * to_elbow +
              std::sqrt(1.0f - way * way) * radius * outwards.stableNormalized();
  }
}

}  // namespace knuckle
