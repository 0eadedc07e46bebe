// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/adult_skeleton.h"

#include <filesystem>

#include "knuckle/core/testing.h"
#include "knuckle/hand/body_skeleton.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/people/body_shape.h"

namespace knuckle {
namespace {

TEST(MakeHumanAdultTest, IsTheHandOfTheMeanBody) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) {
    GTEST_SKIP() << "MakeHuman's data is not on this machine (scripts/fetch_makehuman.sh)";
  }
  const Body body = makehuman_body(makehuman_folder());
  const HandSkeleton expected = skeleton_of(shaped_body(body, shape_coefficients(body, {})), "adult");
  const HandSkeleton& adult = adult_skeleton();
  EXPECT_EQ(adult.name, expected.name);
  for (int i = 0; i < kSupersetSize; ++i) {
    EXPECT_EQ(adult.landmarks[i].bone, expected.landmarks[i].bone) << i;
    EXPECT_LT((adult.landmarks[i].straight_mm - expected.landmarks[i].straight_mm).norm(), 1e-3) << i;
  }
  for (int i = 0; i < kHandBoneCount; ++i) {
    const SkeletonBone& bone = adult.bones[i];
    EXPECT_EQ(bone.parent, expected.bones[i].parent) << i;
    EXPECT_LT((bone.joint_mm - expected.bones[i].joint_mm).norm(), 1e-3) << i;
    ASSERT_EQ(bone.turns.size(), expected.bones[i].turns.size()) << i;
    for (std::size_t k = 0; k < bone.turns.size(); ++k) {
      EXPECT_EQ(bone.turns[k].angle, expected.bones[i].turns[k].angle);
      EXPECT_EQ(bone.turns[k].share, expected.bones[i].turns[k].share);
      EXPECT_LT((bone.turns[k].axis - expected.bones[i].turns[k].axis).norm(), 1e-5);
    }
  }
}

}  // namespace
}  // namespace knuckle
