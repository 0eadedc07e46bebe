// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/fitted_flesh.h"

#include "knuckle/core/testing.h"
#include "knuckle/data/fitted_hand_testing.h"
#include "knuckle/hand/hand_flesh.h"

namespace knuckle {
namespace {

HandRecord fitted_hand() {
  return testing::fitted_hand({10.0, 20.0, 500.0});
}

TEST(FittedFlesh, IsThatOfItsLandmarksInAnyOrder) {
  const HandRecord hand = fitted_hand();
  const std::vector<FleshCone> cones = fitted_flesh(hand);
  ASSERT_EQ(cones.size(), static_cast<std::size_t>(kFleshCount));
  HandRecord ordered = hand;
  ordered.convention = convention_from_name("mediapipe21");
  ordered.landmarks_mm.clear();
  for (const Landmark landmark : ordered.convention.landmarks)
    ordered.landmarks_mm.push_back(hand.landmarks_mm[static_cast<std::size_t>(landmark)]);
  const std::vector<FleshCone> same = fitted_flesh(ordered);
  ASSERT_EQ(same.size(), cones.size()) << "no cone ends at the palm's centre";
  for (std::size_t i = 0; i < cones.size(); ++i) {
    EXPECT_EQ(same[i].from, cones[i].from);
    EXPECT_EQ(same[i].to, cones[i].to);
    EXPECT_EQ(same[i].radius_from, cones[i].radius_from);
  }
}

TEST(FittedFlesh, IsOfFittedHandsAlone) {
  HandRecord hand = fitted_hand();
  hand.skeleton.clear();
  EXPECT_TRUE(fitted_flesh(hand).empty());
  hand = fitted_hand();
  for (Point3& point : hand.landmarks_mm) point = Point3::Constant(kNaN);
  EXPECT_TRUE(fitted_flesh(hand).empty());
  HandRecord nothing;
  nothing.skeleton = "adult";
  EXPECT_TRUE(fitted_flesh(nothing).empty());
}

}  // namespace
}  // namespace knuckle
