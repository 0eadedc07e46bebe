// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skeleton_fit.h"

#include <cmath>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/skeleton_energy.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

using testing::random_angles;
using testing::random_direction;
using testing::random_pose;
using Points = std::array<Point3, kSupersetSize>;

LandmarkTargets targets_at(const Points& points) {
  LandmarkTargets targets;
  for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i];
  return targets;
}

double mean_distance(const Points& a, const Points& b) {
  double sum = 0.0;
  for (int i = 0; i < kSupersetSize; ++i) sum += (a[i] - b[i]).norm();
  return sum / kSupersetSize;
}

/// A pose that the limits allow, in front of a camera.
SkeletonPose some_pose(Random& random, double size = 1.0) {
  return {clamped(random_angles(adult_skeleton().limits, random), adult_skeleton().limits),
          random_pose(random), size};
}

/// Deviations with which the landmarks alone decide.
constexpr SkeletonFitOptions kExact{
    .noise_mm = 0.01, .posture_spread = 25.0, .size_spread = 0.2, .most_steps = 200};

TEST(SkeletonFit, LandmarksAreThoseOfTheScaledSkeleton) {
  Random random(1);
  for (const double size : {0.7, 1.0, 1.2}) {
    const SkeletonPose pose = some_pose(random, size);
    const Points expected = landmarks(scaled(adult_skeleton(), size), pose.angles, pose.camera_from_hand);
    EXPECT_LT(mean_distance(landmarks(adult_skeleton(), pose), expected), 1e-9);
  }
}

TEST(SkeletonFit, FindsTheAnglesThatMadeTheLandmarks) {
  Random random(2);
  int found = 0;
  constexpr int kManyTrials = 60;
  for (int trial = 0; trial < kManyTrials; ++trial) {
    const SkeletonPose truth = some_pose(random, random.uniform(0.85, 1.15));
    const Points points = landmarks(adult_skeleton(), truth);
    const auto fit = fit_skeleton(adult_skeleton(), targets_at(points), kExact);
    ASSERT_TRUE(fit);
    EXPECT_TRUE(within_limits(fit->pose.angles));
    if (mean_distance(landmarks(adult_skeleton(), fit->pose), points) > 0.1) continue;
    ++found;
    EXPECT_NEAR(fit->pose.size, truth.size, 0.002);
    // A straight finger's spread cannot be told from its neighbours' only where its points do not move.
    EXPECT_NEAR(fit->pose.angles[HandAngle::index_pip], truth.angles[HandAngle::index_pip], 0.02);
    EXPECT_NEAR(fit->pose.angles[HandAngle::little_mcp], truth.angles[HandAngle::little_mcp], 0.05);
  }
  EXPECT_GE(found, kManyTrials * 9 / 10) << "of angles anywhere within the limits, also crooked ones";
}

TEST(SkeletonFit, TheEnergyIsLowestWhereItEnds) {
  Random random(3);
  const SkeletonFitOptions options;
  for (int trial = 0; trial < 10; ++trial) {
    Points points = landmarks(adult_skeleton(), some_pose(random));
    for (Point3& point : points) point += 6.0 * random_direction(random);
    const LandmarkTargets targets = targets_at(points);
    SkeletonFitOptions patient = options;
    patient.most_steps = 500;
    const auto fit = fit_skeleton(adult_skeleton(), targets, patient);
    ASSERT_TRUE(fit);
    // One more step from anywhere near does not end lower.
    for (int k = 0; k < 20; ++k) {
      SkeletonPose near = fit->pose;
      for (double& angle : near.angles.radians) angle += random.uniform(-0.01, 0.01);
      near.camera_from_hand =
          moved(near.camera_from_hand, 0.01 * random_direction(random), random_direction(random));
      const auto again = fit_skeleton(adult_skeleton(), targets, {.most_steps = 1}, near);
      EXPECT_GE(again->energy, fit->energy - 1e-3 * (1.0 + fit->energy));
    }
  }
}

TEST(SkeletonFit, MoreStepsNeverRaiseTheEnergy) {
  Random random(4);
  Points points = landmarks(adult_skeleton(), some_pose(random));
  for (Point3& point : points) point += 10.0 * random_direction(random);
  double before = std::numeric_limits<double>::infinity();
  for (int steps = 1; steps < 30; ++steps) {
    const auto fit = fit_skeleton(adult_skeleton(), targets_at(points), {.most_steps = steps});
    EXPECT_LE(fit->energy, before);
    before = fit->energy;
  }
}

TEST(SkeletonFit, TakesNoiseOutOfLandmarks) {
  Random random(5);
  double before = 0.0;
  double after = 0.0;
  for (int trial = 0; trial < 100; ++trial) {
    const Points truth = landmarks(adult_skeleton(), some_pose(random));
    Points noisy = truth;
    for (Point3& point : noisy) point += Point3(random.normal(), random.normal(), random.normal()) * 8.0;
    const auto fit = fit_skeleton(adult_skeleton(), targets_at(noisy), {.noise_mm = 8.0});
    before += mean_distance(noisy, truth) / 100;
    after += mean_distance(landmarks(adult_skeleton(), fit->pose), truth) / 100;
  }
  // 29 unknowns out of 66 numbers: sqrt(29 / 66) = 0.66 of the error is left, less with what is known before.
  EXPECT_LT(after, 0.72 * before);
  EXPECT_GT(after, 0.3 * before);
}

TEST(SkeletonFit, TargetsThatAreUnsureInDepthHoldAcrossTheLineOfSight) {
  const SkeletonPose truth{resting_hand(), RigidTransform(Eigen::Translation3d(0, 0, 600)), 1.0};
  const Points points = landmarks(adult_skeleton(), truth);
  LandmarkTargets targets = targets_at(points);
  for (LandmarkTarget& target : targets) target.point *= 1.05;  // 30 mm too far
  constexpr std::size_t kTrue = 0;
  targets[kTrue].point = points[kTrue];
  const auto depth_of = [&](double depth_weight) {
    for (std::size_t i = 1; i < targets.size(); ++i) targets[i].depth_weight = depth_weight;
    return fit_skeleton(adult_skeleton(), targets, {.size_spread = 0.0})
        ->pose.camera_from_hand.translation()
        .z();
  };
  EXPECT_GT(depth_of(1.0), 612.0) << "21 landmarks against one, the wrist";
  EXPECT_NEAR(depth_of(0.0), 600.0, 6.0) << "one says how far";
  targets[kTrue].depth_weight = -1.0;
  EXPECT_THROW(depth_of(1.0), Error);
}

TEST(SkeletonFit, LandmarksThatWereNotFoundComeFromTheRest) {
  Random random(6);
  for (int trial = 0; trial < 20; ++trial) {
    SkeletonPose truth{HandAngles{}, random_pose(random), 1.0};
    for (int finger = 0; finger < 4; ++finger) {
      const FingerAngleNames names = angles_of_finger(finger);
      truth.angles[names.mcp] = 0.3;
      truth.angles[names.pip] = 0.6;
      truth.angles[names.dip] = coupled_dip(0.6);
    }
    truth.angles[HandAngle::thumb_radial] = 0.4;
    truth.angles[HandAngle::thumb_palmar] = 0.5;
    const Points points = landmarks(adult_skeleton(), truth);
    LandmarkTargets targets = targets_at(points);
    targets[static_cast<int>(Landmark::middle_tip)].point = Point3::Constant(kNaN);
    targets[static_cast<int>(Landmark::little_pip)].weight = 0.0;
    targets[static_cast<int>(Landmark::little_pip)].point = Point3(9000.0, 0.0, 0.0);
    const auto fit = fit_skeleton(adult_skeleton(), targets);
    ASSERT_TRUE(fit);
    const Points fitted = landmarks(adult_skeleton(), fit->pose);
    for (int i = 0; i < kSupersetSize; ++i) EXPECT_LT((fitted[i] - points[i]).norm(), 8.0) << i;
  }
}

TEST(SkeletonFit, AHiddenFingerBendsAsItsNeighboursDo) {
  const auto bend_of_ring = [](double bend) {
    SkeletonPose truth{resting_hand(), RigidTransform(Eigen::Translation3d(0, 0, 600)), 1.0};
    for (int finger = 0; finger < 4; ++finger) {
      const FingerAngleNames names = angles_of_finger(finger);
      truth.angles[names.mcp] = truth.angles[names.pip] = bend;
      truth.angles[names.dip] = coupled_dip(bend);
    }
    LandmarkTargets targets = targets_at(landmarks(adult_skeleton(), truth));
    for (const Landmark hidden : {Landmark::ring_pip, Landmark::ring_dip, Landmark::ring_tip})
      targets[static_cast<std::size_t>(hidden)].weight = 0.0;
    return fit_skeleton(adult_skeleton(), targets)->pose.angles[HandAngle::ring_pip];
  };
  EXPECT_NEAR(bend_of_ring(0.1), 0.1, 0.3);
  EXPECT_NEAR(bend_of_ring(1.4), 1.4, 0.3);
}

TEST(SkeletonFit, ALeftSkeletonFitsTheMirrorImage) {
  Random random(7);
  const HandSkeleton left = mirrored(adult_skeleton());
  Points points = landmarks(adult_skeleton(), some_pose(random));
  for (Point3& point : points) point += 5.0 * random_direction(random);
  const auto right_fit = fit_skeleton(adult_skeleton(), targets_at(points));
  for (Point3& point : points) point.x() = -point.x();
  const auto left_fit = fit_skeleton(left, targets_at(points));
  EXPECT_NEAR(left_fit->energy, right_fit->energy, 1e-6 * right_fit->energy);
  for (int i = 0; i < kHandAngleCount; ++i)
    EXPECT_NEAR(left_fit->pose.angles.radians[i], right_fit->pose.angles.radians[i], 1e-4) << i;
}

TEST(SkeletonFit, ThreeTargetsAreNeededAndOptionsChecked) {
  const Points points = landmarks(adult_skeleton(), SkeletonPose{});
  LandmarkTargets targets;
  targets[0].point = points[0];
  targets[6].point = points[6];
  EXPECT_FALSE(fit_skeleton(adult_skeleton(), targets));
  targets[18].point = points[18];
  EXPECT_TRUE(fit_skeleton(adult_skeleton(), targets));
  const auto fault = [&](const SkeletonFitOptions& options) {
    return testing::error_of([&] { fit_skeleton(adult_skeleton(), targets, options); });
  };
  EXPECT_THAT(fault({.noise_mm = 0.0}), ::testing::HasSubstr("noise_mm is 0"));
  EXPECT_THAT(fault({.posture_spread = kNaN}), ::testing::HasSubstr("posture_spread"));
  EXPECT_THAT(fault({.size_spread = -1.0}), ::testing::HasSubstr("size_spread is -1"));
  EXPECT_THAT(fault({.most_steps = 0}), ::testing::HasSubstr("most_steps is 0"));
  targets[0].weight = 0.0;
  EXPECT_FALSE(fit_skeleton(adult_skeleton(), targets)) << "what has no confidence is no target";
  targets[0].weight = -1.0;
  EXPECT_THAT(fault({}), ::testing::HasSubstr("a landmark's weight is -1"));
  targets[0].weight = 1.0;
  targets[0].depth_weight = -1.0;
  EXPECT_THAT(fault({}), ::testing::HasSubstr("depth_weight is -1, expected 0 or more"));
}

TEST(SkeletonFit, BeginsWithTheProportionsThatAreKnown) {
  SkeletonFitOptions options = kExact;
  options.size = 1.1;
  options.size_spread = options.length_spread = 0.0;
  for (auto& digit : options.lengths) digit = {1.3, 0.8, 1.2};
  Random random(9);
  const SkeletonPose truth{resting_hand(), random_pose(random), options.size, options.lengths};
  const LandmarkTargets targets = targets_at(landmarks(adult_skeleton(), truth));
  // The resting hand is among the first guesses: laid on its own landmarks it needs no step.
  options.most_steps = 1;
  EXPECT_LT(fit_skeleton(adult_skeleton(), targets, options)->rms_mm, 0.01);
}

TEST(SkeletonFit, WithoutASpreadTheSizeStays) {
  Random random(8);
  const Points points = landmarks(adult_skeleton(), some_pose(random, 1.3));
  EXPECT_EQ(fit_skeleton(adult_skeleton(), targets_at(points), {.size_spread = 0.0})->pose.size, 1.0);
  EXPECT_GT(fit_skeleton(adult_skeleton(), targets_at(points))->pose.size, 1.15);
}

}  // namespace
}  // namespace knuckle
