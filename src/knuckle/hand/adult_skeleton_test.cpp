// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/adult_skeleton.h"

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

/// Bones of thumb to little, from the palm outwards, as fractions of hand length: Buchholz et al. 1992.
constexpr std::array<std::array<double, 3>, 5> kFractions{{{0.251, 0.196, 0.158},
                                                           {0.245, 0.143, 0.097},
                                                           {0.266, 0.170, 0.108},
                                                           {0.244, 0.165, 0.107},
                                                           {0.204, 0.117, 0.093}}};

TEST(AdultSkeletonTest, HasTheProportionsOfPeople) {
  const HandSkeleton& adult = adult_skeleton();
  check(adult);
  const auto lengths = digit_lengths_mm(adult);
  const double hand_length =
      adult.landmarks[static_cast<std::size_t>(Landmark::middle_tip)].straight_mm.norm();
  EXPECT_GT(hand_length, 171.0);  // women's mean less a deviation, men's and one: ANSUR II, 2012
  EXPECT_LT(hand_length, 203.0);
  for (int digit = 0; digit < 5; ++digit) {
    for (int joint = 0; joint < 3; ++joint) {
      // Landmarks at tips lie a tenth of the last bone inside its end.
      const double expected = kFractions[digit][joint] * hand_length * (joint == 2 ? 0.9 : 1.0);
      EXPECT_NEAR(lengths[digit][joint], expected, 0.08 * expected) << digit << " " << joint;
    }
  }
}

TEST(AdultSkeletonTest, AFistPutsTheTipsAtThePalm) {
  HandAngles fist;
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    fist[names.mcp] = 1.4;
    fist[names.pip] = 1.8;
    fist[names.dip] = 1.0;
  }
  const auto points = landmarks(adult_skeleton(), fist, RigidTransform::Identity());
  for (int digit = 1; digit < 5; ++digit) {
    const Point3& tip = points[static_cast<std::size_t>(landmark_of_digit(digit, 3))];
    EXPECT_GT(tip.z(), 5.0);  // before the palm
    EXPECT_LT((tip - points[static_cast<std::size_t>(Landmark::palm)]).norm(), 60.0) << digit;
  }
}

TEST(AdultSkeletonTest, AThumbBeforeThePalmBendsTowardsTheLittleFinger) {
  const auto to_little_finger_mm = [](double bend) {
    HandAngles thumb;
    thumb[HandAngle::thumb_palmar] = 0.9;
    thumb[HandAngle::thumb_mcp] = thumb[HandAngle::thumb_ip] = bend;
    const auto points = landmarks(adult_skeleton(), thumb, RigidTransform::Identity());
    return (points[static_cast<std::size_t>(Landmark::thumb_tip)] -
            points[static_cast<std::size_t>(Landmark::little_mcp)])
        .norm();
  };
  EXPECT_LT(to_little_finger_mm(0.6), to_little_finger_mm(0.0) - 25.0);
}

}  // namespace
}  // namespace knuckle
