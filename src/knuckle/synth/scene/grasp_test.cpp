// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/grasp.h"

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/hand_collision.h"

namespace knuckle {
namespace {

class EveryGrasp : public ::testing::TestWithParam<std::string_view> {};

/// The gap by brute force: many points of every bone, less its flesh.
double brute_gap(const HandSkeleton& skeleton, const Grasp& grasp) {
  const auto hand = landmarks(skeleton, grasp.hand, RigidTransform::Identity());
  const RigidTransform thing_from_hand = grasp.hand_from_thing.inverse();
  double least = 1e9;
  for (const HandCapsule& capsule : hand_capsules(hand)) {
    for (int i = 0; i <= 30; ++i) {
      const Point3 point = capsule.from + (capsule.to - capsule.from) * (i / 30.0);
      const Eigen::Vector3f place = (thing_from_hand * point).cast<float>();
      least = std::min(least, distance_mm(grasp.thing.solids, place) - capsule.radius);
    }
  }
  return least;
}

TEST_P(EveryGrasp, TouchesAndDoesNotRunIntoTheHand) {
  const HandSkeleton& skeleton = adult_skeleton();
  const std::vector<std::string> names = {std::string(GetParam())};
  int held = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    Random random(4, i);
    const auto grasp = sampled_grasp(skeleton, names, random);
    if (!grasp) continue;
    ++held;
    const double gap = brute_gap(skeleton, *grasp);
    EXPECT_GT(gap, -9.0) << i;
    EXPECT_LT(gap, 2.5) << "it touches " << i;
    EXPECT_EQ(clamped(grasp->hand), grasp->hand) << "within the limits of the joints";
    EXPECT_FALSE(grasp->thing.mesh.faces.empty());
  }
  EXPECT_GT(held, 10) << "of 60";
}

INSTANTIATE_TEST_SUITE_P(Grasps, EveryGrasp, ::testing::ValuesIn(grasp_names().begin(), grasp_names().end()),
                         [](const auto& parameter) { return std::string(parameter.param); });

TEST(Grasps, ThickerThingsAreHeldWithStraighterFingers) {
  const HandSkeleton& skeleton = adult_skeleton();
  double thin = 0.0;
  double thick = 0.0;
  int thin_count = 0;
  int thick_count = 0;
  for (std::uint64_t i = 0; i < 400; ++i) {
    Random random(5, i);
    const auto grasp = sampled_grasp(skeleton, {"cylinder"}, random);
    if (!grasp) continue;
    const float radius = grasp->thing.solids.front().size.x();
    const double bend = grasp->hand[HandAngle::middle_mcp] + grasp->hand[HandAngle::middle_pip];
    if (radius < 18.0f) {
      thin += bend;
      ++thin_count;
    } else if (radius > 32.0f) {
      thick += bend;
      ++thick_count;
    }
  }
  ASSERT_GT(thin_count, 5);
  ASSERT_GT(thick_count, 3);
  EXPECT_GT(thin / thin_count, thick / thick_count + 0.1);
}

TEST(Grasps, OneOfTheGivenNamesIsKnown) {
  Random random(4, 1);
  EXPECT_THAT(testing::error_of([&] { sampled_grasp(adult_skeleton(), {"teeth"}, random); }),
              ::testing::HasSubstr("none of the given names is one"));
}

TEST(Grasps, ComeFromTheStreamAlone) {
  Random a(6, 1);
  Random b(6, 1);
  const auto one = sampled_grasp(adult_skeleton(), {}, a);
  const auto two = sampled_grasp(adult_skeleton(), {}, b);
  ASSERT_EQ(one.has_value(), two.has_value());
  if (one) {
    EXPECT_EQ(one->hand, two->hand);
    EXPECT_EQ(one->hand_from_thing.matrix(), two->hand_from_thing.matrix());
  }
}

}  // namespace
}  // namespace knuckle
