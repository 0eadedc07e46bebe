// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_estimate.h"

#include "knuckle/core/testing.h"
#include "knuckle/label/label_testing.h"

namespace knuckle {
namespace {

TEST(LabelEstimate, LabellingBeginsWithTheFirstHandOfEachSide) {
  HandPose known = testing::pose_of_points(testing::bent_hand_points(0.3));
  known.joints[5] = ImagePoint();
  HandPose other = known;
  other.joints[0].u += 9.0;
  const auto changes =
      estimated_changes(4, {{HandSide::left, known}, {HandSide::left, other}, {HandSide::right, other}},
                        superset_convention(), "pipeline", "2026-11-23T17:40:58Z");
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].side, HandSide::left);
  EXPECT_EQ(changes[1].side, HandSide::right);
  EXPECT_EQ(changes[1].landmarks[0].at.u, other.joints[0].u);
  EXPECT_EQ(changes[0].frame, 4);
  EXPECT_EQ(changes[0].revision, 1);
  EXPECT_EQ(changes[0].act, LabelAct::estimate);
  EXPECT_EQ(changes[0].author, "pipeline");
  EXPECT_EQ(changes[0].time, "2026-11-23T17:40:58Z");
  ASSERT_EQ(changes[0].landmarks.size(), known.joints.size());
  for (std::size_t i = 0; i < known.joints.size(); ++i) {
    const LandmarkLabel& label = changes[0].landmarks[i];
    EXPECT_EQ(label.at.is_missing(), i == 5) << i;
    EXPECT_TRUE(label.is_visible);
    EXPECT_EQ(label.state, LabelState::estimated);
    if (i == 5) continue;
    EXPECT_EQ(label.at.u, known.joints[i].u);
  }
}

}  // namespace
}  // namespace knuckle
