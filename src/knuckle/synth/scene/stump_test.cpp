// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/stump.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

/// A forearm along y with rings every 10 mm, and a thumb that stands out.
struct TubeArm {
  static constexpr float kRadius = 25.0f;
  std::vector<Vector3f> skin;
  std::vector<float> along_mm;

  TubeArm() {
    for (int along = -180; along <= 250; along += 10) {
      for (int k = 0; k < 12; ++k) {
        const float angle = static_cast<float>(k) * std::numbers::pi_v<float> / 6.0f;
        add({kRadius * std::cos(angle), static_cast<float>(along), kRadius * std::sin(angle)});
      }
    }
    add({0.0f, -60.0f, 120.0f});
  }
  void add(const Vector3f& point) {
    along_mm.push_back(point.y());
    skin.push_back(point + wrist());
  }
  static Vector3f wrist() { return {100.0f, -40.0f, 600.0f}; }
  static Vector3f elbow() { return wrist() + Vector3f(0.0f, 250.0f, 0.0f); }
};

TEST(Stump, EndsTheArmAndLeavesTheRest) {
  for (const Stump stump : {Stump{0.0f, 20.0f}, Stump{75.0f, 40.0f}, Stump{75.0f, 0.0f}}) {
    const TubeArm before;
    TubeArm arm;
    end_in_stump(arm.skin, arm.along_mm, stump, TubeArm::wrist(), TubeArm::elbow());
    float farthest = 0.0f;
    for (std::size_t i = 0; i < arm.skin.size(); ++i) {
      if (arm.along_mm[i] >= stump.from_mm) {
        EXPECT_EQ(arm.skin[i], before.skin[i]);
        continue;
      }
      const Vector3f from_wrist = arm.skin[i] - TubeArm::wrist();
      const float beyond = stump.from_mm - from_wrist.y();
      farthest = std::max(farthest, beyond);
      EXPECT_LE(beyond, stump.depth_mm + 1e-3f);
      EXPECT_GE(beyond, -1e-3f);
      // On the quarter of an ellipse between the arm's skin and the tip.
      const float way = stump.depth_mm > 0.0f ? beyond / stump.depth_mm : 1.0f;
      const float radius = std::hypot(from_wrist.x(), from_wrist.z());
      EXPECT_NEAR(radius, way > 1.0f - 1e-5f ? 0.0f : TubeArm::kRadius * std::sqrt(1.0f - way * way), 0.1f);
    }
    EXPECT_NEAR(farthest, stump.depth_mm, 1e-3f) << "all that is farther is drawn together to the tip";
  }
}

TEST(Stump, IsAnywhereBetweenWristAndMiddleOfTheForearm) {
  Random random(5, 0);
  int near_wrist = 0;
  int round = 0;
  for (int i = 0; i < 400; ++i) {
    const Stump stump = sampled_stump(random);
    EXPECT_GE(stump.from_mm, 0.0f);
    EXPECT_LT(stump.from_mm, 150.0f);
    EXPECT_GE(stump.depth_mm, 0.0f);
    EXPECT_LT(stump.depth_mm, 40.0f);
    near_wrist += stump.from_mm < 75.0f ? 1 : 0;
    round += stump.depth_mm > 0.0f ? 1 : 0;
  }
  EXPECT_NEAR(near_wrist, 200, 50);
  EXPECT_NEAR(round, 200, 50);
}

}  // namespace
}  // namespace knuckle
