// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/person_hand.h"

#include <cmath>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(PersonHand, TellsTheGeometricMeanOfWhatItLearned) {
  SkeletonPose small;
  small.size = 0.9;
  small.lengths[2][1] = 0.8;
  SkeletonPose large;
  large.size = 1.1;
  large.lengths[2][1] = 1.3;
  PersonHand person;
  person.learn(small);
  person.learn(large);
  SkeletonFitOptions options;
  person.tell(options);
  EXPECT_NEAR(options.size, std::sqrt(0.9 * 1.1), 1e-12);
  EXPECT_NEAR(options.lengths[2][1], std::sqrt(0.8 * 1.3), 1e-12);
  EXPECT_NEAR(options.lengths[1][2], 1.0, 1e-12);
  EXPECT_EQ(options.size_spread, 0.0) << "a fit keeps to it";
  EXPECT_EQ(options.length_spread, 0.0);
}

TEST(PersonHand, TellsNothingWhereNothingWasLearned) {
  SkeletonFitOptions options;
  PersonHand().tell(options);
  EXPECT_EQ(options.size_spread, SkeletonFitOptions().size_spread);
  EXPECT_EQ(options.length_spread, SkeletonFitOptions().length_spread);
  EXPECT_GT(options.size_spread, 0.0);
}

}  // namespace
}  // namespace knuckle
