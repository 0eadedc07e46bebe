// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/skeleton_energy.h"

#include <cmath>
#include <limits>

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/hand_collision.h"
#include "knuckle/hand/skeleton_testing.h"

namespace knuckle {
namespace {

using testing::random_direction;
using Points = std::array<Point3, kSupersetSize>;

SkeletonPose some_hand(Random& random) {
  SkeletonPose pose{resting_hand(), testing::random_pose(random), random.uniform(0.9, 1.1)};
  for (double& angle : pose.angles.radians) angle += random.uniform(-0.1, 0.1);
  for (auto& digit : pose.lengths) {
    for (double& factor : digit) factor = random.uniform(0.9, 1.1);
  }
  return pose;
}

double palm_of(const SkeletonPose& pose) {
  const HandSkeleton& adult = adult_skeleton();
  const auto at = [&](Landmark landmark) {
    return adult.landmarks[static_cast<std::size_t>(landmark)].straight_mm;
  };
  return pose.size * (at(Landmark::middle_mcp) - at(Landmark::wrist)).norm();
}

/// Points on the skin of a hand: a place on the line of each piece of flesh, and as far from it as the flesh
/// is thick.
std::vector<Point3> skin_of(const SkeletonPose& pose, Random& random, int per_piece) {
  const Points points = landmarks(adult_skeleton(), pose);
  const PosedFlesh posed(points, palm_of(pose));
  std::vector<Point3> skin;
  for (const HandFlesh& flesh : hand_flesh()) {
    const Point3& from = points[static_cast<std::size_t>(flesh.from)];
    const Point3& to = points[static_cast<std::size_t>(flesh.to)];
    for (int i = 0; i < per_piece; ++i) {
      const double share = random.uniform(0.0, 1.0);
      const Eigen::Vector3d across = (to - from).cross(random_direction(random)).normalized();
      const double radius = (1.0 - share) * flesh.radius_from + share * flesh.radius_to;
      const Point3 point = (1.0 - share) * from + share * to + radius * palm_of(pose) * across;
      if (posed.nearest(point).gap_mm > -1.0) skin.push_back(point);  // not within another piece
    }
  }
  return skin;
}

/// The pose a step away, without limits.
SkeletonPose unlimited_step(SkeletonPose pose, const SkeletonStep& step) {
  for (int i = 0; i < kHandAngleCount; ++i) pose.angles.radians[i] += step[i];
  pose.camera_from_hand =
      moved(pose.camera_from_hand, step.segment<3>(kTurnColumn), step.segment<3>(kShiftColumn));
  pose.size *= std::exp(step[kSizeColumn]);
  for (int i = 0; i < 15; ++i) pose.lengths[i / 3][i % 3] *= std::exp(step[kLengthColumn + i]);
  return pose;
}

TEST(SkeletonEnergy, LandmarksChangeAsTheirDerivativesSay) {
  Random random(1);
  const SkeletonPose pose = some_hand(random);
  PoseJacobian jacobian;
  const Points points = landmarks(adult_skeleton(), pose, jacobian);
  constexpr double kStep = 1e-6;
  for (int unknown = 0; unknown < kSkeletonUnknowns; ++unknown) {
    const SkeletonStep step = kStep * SkeletonStep::Unit(unknown);
    const Points after = landmarks(adult_skeleton(), unlimited_step(pose, step));
    const Points before = landmarks(adult_skeleton(), unlimited_step(pose, -step));
    for (int i = 0; i < kSupersetSize; ++i) {
      const Point3 difference = (after[i] - before[i]) / (2.0 * kStep);
      EXPECT_LT((difference - jacobian.block<3, 1>(3 * i, unknown)).norm(), 1e-6 * 200.0)
          << "unknown " << unknown << ", landmark " << i;
    }
    EXPECT_EQ(points[0], landmarks(adult_skeleton(), pose)[0]);
  }
}

TEST(SkeletonEnergy, ItsGradientIsThatOfFiniteDifferences) {
  Random random(2);
  for (int trial = 0; trial < 5; ++trial) {
    const SkeletonPose pose = some_hand(random);
    LandmarkTargets targets;
    const Points points = landmarks(adult_skeleton(), pose);
    for (int i = 0; i < kSupersetSize; ++i) {
      targets[i] = {points[i] + 5.0 * random_direction(random), random.uniform(0.0, 1.0)};
      if (i % 2 == 0) targets[i].depth_weight = 0.1 * i;
    }
    HandSurface surface{skin_of(pose, random, 3)};
    for (Point3& point : surface.points) point += 4.0 * random_direction(random);
    surface.depth_mm = [](const Point3& point) {
      return point.x() > 0.0 ? 5000.0 : 0.0;
    };  // half of it floats
    SkeletonFitOptions options;
    options.expected = resting_hand();
    options.bone_mm = trial % 2 == 0 ? 3.0 : 0.0;
    options.overlap_mm = 0.5;
    targets[7].point.x() = kNaN;
    const SkeletonEnergy energy(adult_skeleton(), targets, surface, options);
    const Linearised at = energy.linearised(pose);
    EXPECT_NEAR(at.energy, energy.at(pose), 1e-9 * at.energy);
    constexpr double kStep = 1e-6;
    for (int unknown = 0; unknown < kSkeletonUnknowns; ++unknown) {
      const SkeletonStep step = kStep * SkeletonStep::Unit(unknown);
      const double slope =
          (energy.at(unlimited_step(pose, step)) - energy.at(unlimited_step(pose, -step))) / (2.0 * kStep);
      EXPECT_NEAR(at.gradient[unknown], slope, 1e-6 * at.gradient.norm()) << "unknown " << unknown;
    }
  }
}

TEST(SkeletonEnergy, BonesAreComparedWithTheWayBetweenTheirTargets) {
  Random random(12);
  const SkeletonPose pose = some_hand(random);
  const Points points = landmarks(adult_skeleton(), pose);
  LandmarkTargets targets;  // all unknown but three
  const auto set = [&](Landmark landmark, const Point3& away, double weight) {
    const auto i = static_cast<std::size_t>(landmark);
    targets[i] = {points[i] + away, weight};
  };
  set(Landmark::ring_mcp, {1.0, 0.0, 0.0}, 1.0);
  set(Landmark::ring_pip, {4.0, 0.0, 0.0}, 0.25);
  set(Landmark::ring_tip, {9.0, 9.0, 9.0}, 1.0);  // its neighbour is not known
  const auto energy_of = [&](double bone_mm) {
    const SkeletonFitOptions options{.bone_mm = bone_mm};
    return SkeletonEnergy(adult_skeleton(), targets, {}, options).at(pose);
  };
  // One bone, 3 mm off; its weight is the root of 1 times 0.25.
  EXPECT_NEAR(energy_of(2.0) - energy_of(0.0), 0.5 * 0.5 * 9.0 / 4.0, 1e-9);
  set(Landmark::ring_pip, {1.0, 0.0, 0.0}, 0.25);
  EXPECT_NEAR(energy_of(2.0), energy_of(0.0), 1e-9) << "both are off by the same";
}

TEST(SkeletonEnergy, DigitsThatRunIntoOneAnotherCost) {
  SkeletonPose pose{bent_hand(0.4, 0.4)};
  const auto set_index = [&](double spread) {
    pose.angles[angles_of_finger(0).spread] = spread;
    return landmarks(adult_skeleton(), pose);
  };
  const auto overlap_energy = [&] {
    const auto with = SkeletonFitOptions{.overlap_mm = 2.0};
    const auto without = SkeletonFitOptions{};
    return SkeletonEnergy(adult_skeleton(), {}, {}, with).at(pose) -
           SkeletonEnergy(adult_skeleton(), {}, {}, without).at(pose);
  };
  double deepest = 0.0;
  for (const double spread : {0.3, 0.0, -0.3, -0.6}) {
    const Points points = set_index(spread);
    const double worst = worst_penetration_mm(points);
    double expected = 0.0;
    for (const BoneCollision& collision : collisions_of(points, 6.0))
      expected += 0.5 * std::pow((collision.depth_mm - 6.0) / 2.0, 2.0);
    EXPECT_NEAR(overlap_energy(), expected, 1e-9 * (1.0 + expected)) << spread;
    EXPECT_EQ(overlap_energy() > 1e-12, worst > 6.0) << spread;
    deepest = std::max(deepest, worst);
  }
  EXPECT_GT(deepest, 8.0) << "else nothing is tested";
}

TEST(SkeletonFit, DigitsDoNotGoThroughOneAnother) {
  // Index and middle finger are both said to be where the middle finger is.
  const Points points = landmarks(adult_skeleton(), SkeletonPose{bent_hand(0.4, 0.4)});
  LandmarkTargets targets;
  for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i];
  constexpr int kIndex = static_cast<int>(Landmark::index_pip);
  constexpr int kMiddle = static_cast<int>(Landmark::middle_pip);
  for (int i = 0; i < 3; ++i) targets[kIndex + i].point = points[kMiddle + i];
  const auto worst_of = [&](double overlap_mm) {
    const auto fit = fit_skeleton(adult_skeleton(), targets, {.overlap_mm = overlap_mm});
    return worst_penetration_mm(landmarks(adult_skeleton(), fit->pose));
  };
  EXPECT_GT(worst_of(0.0), 9.0);
  EXPECT_LT(worst_of(0.3), 7.0);
}

TEST(SkeletonFit, ADigitThatIsSeenBesideItsPlaceKeepsItsBend) {
  Random random(13);
  double bent_mm = 0.0;
  double kept_mm = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    const SkeletonPose truth = some_hand(random);
    const Points points = landmarks(adult_skeleton(), truth);
    LandmarkTargets targets;
    for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i];
    const auto first = static_cast<int>(Landmark::middle_mcp);
    const Point3 away = 8.0 * random_direction(random);
    for (int i = first; i < first + 4; ++i) targets[i].point += away;
    const auto error_of = [&](double bone_mm) {
      const SkeletonFitOptions options{.bone_mm = bone_mm,
                                       .size = truth.size,
                                       .size_spread = 0.0,
                                       .lengths = truth.lengths,
                                       .length_spread = 0.0};
      const auto fit = fit_skeleton(adult_skeleton(), targets, options, truth, {skin_of(truth, random, 20)});
      const Points fitted = landmarks(adult_skeleton(), fit->pose);
      return ((fitted[first + 3] - fitted[first + 1]) - (points[first + 3] - points[first + 1])).norm();
    };
    bent_mm += error_of(0.0);
    kept_mm += error_of(2.0);
  }
  EXPECT_LT(kept_mm, 0.9 * bent_mm);
}

TEST(PosedFlesh, TheNearestSkinIsThatOfAllSpheresAlongAllPieces) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const SkeletonPose pose = some_hand(random);
    const Points points = landmarks(adult_skeleton(), pose);
    const PosedFlesh posed(points, palm_of(pose));
    const Point3 point = points[9] + random.uniform(0.0, 60.0) * random_direction(random);
    double least = std::numeric_limits<double>::infinity();
    for (const HandFlesh& flesh : hand_flesh()) {
      const Point3& from = points[static_cast<std::size_t>(flesh.from)];
      const Point3& to = points[static_cast<std::size_t>(flesh.to)];
      for (int i = 0; i <= 1000; ++i) {
        const double share = i / 1000.0;
        const double radius = (1.0 - share) * flesh.radius_from + share * flesh.radius_to;
        least = std::min(least, ((1.0 - share) * from + share * to - point).norm() - radius * palm_of(pose));
      }
    }
    const SurfaceContact found = posed.nearest(point);
    EXPECT_NEAR(found.gap_mm, least, 1e-3);
    // The contact's parts agree with one another.
    const Point3 place = (1.0 - found.share) * points[static_cast<std::size_t>(found.flesh->from)] +
                         found.share * points[static_cast<std::size_t>(found.flesh->to)];
    EXPECT_LT((point + (found.gap_mm + found.radius_mm) * found.normal - place).norm(), 1e-9);
  }
}

TEST(PosedFlesh, FloatsWhereSomethingIsSeenThroughIt) {
  Random random(4);
  const SkeletonPose pose = some_hand(random);
  const Points points = landmarks(adult_skeleton(), pose);
  const PosedFlesh posed(points, palm_of(pose));
  const Point3 far = points[0] + Point3(500.0, 0.0, 0.0);
  const auto floating = [&](double behind_mm) {
    const HandSurface surface{{far}, [&](const Point3& at) { return at.z() + behind_mm; }};
    int count = 0;
    for (int i = 0; i < kFloatPlaces; ++i) {
      const SurfaceContact contact = posed.floating(surface, i);
      if (contact.flesh == nullptr) continue;
      ++count;
      EXPECT_GT(contact.gap_mm, 200.0);
      EXPECT_GT(contact.normal.dot(-Point3::UnitX()), 0.5) << "it is drawn to the measured point";
    }
    return count;
  };
  EXPECT_EQ(floating(100.0), kFloatPlaces);
  EXPECT_EQ(floating(5.0), 0) << "its own skin";
  EXPECT_EQ(floating(-50.0), 0) << "something before it";
  EXPECT_EQ(posed.floating({{far}}, 0).flesh, nullptr) << "nobody knows";
  EXPECT_EQ(posed.floating({{}, [](const Point3&) { return 9000.0; }}, 0).flesh, nullptr) << "nowhere to go";
}

TEST(SkeletonFit, ASurfaceTakesNoiseOutOfLandmarks) {
  Random random(5);
  double without = 0.0;
  double with = 0.0;
  double with_clutter = 0.0;
  constexpr int kManyHands = 30;
  for (int trial = 0; trial < kManyHands; ++trial) {
    const SkeletonPose truth = some_hand(random);
    const Points points = landmarks(adult_skeleton(), truth);
    LandmarkTargets targets;
    for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i] + 8.0 * random_direction(random);
    HandSurface surface{skin_of(truth, random, 12)};
    const auto error = [&](const HandSurface& seen) {
      const auto fit = fit_skeleton(adult_skeleton(), targets, {}, std::nullopt, seen);
      const Points found = landmarks(adult_skeleton(), fit->pose);
      double sum = 0.0;
      for (int i = 0; i < kSupersetSize; ++i) sum += (found[i] - points[i]).norm();
      return sum / kSupersetSize / kManyHands;
    };
    without += error({});
    with += error(surface);
    for (int i = 0; i < 60; ++i) surface.points.push_back(points[0] + 70.0 * random_direction(random));
    with_clutter += error(surface);
  }
  EXPECT_LT(with, 0.85 * without);
  EXPECT_LT(with_clutter, 0.9 * without) << "points of other things count little";
}

TEST(SkeletonFit, KnownSizeAndLengthsStay) {
  Random random(6);
  const SkeletonPose truth = some_hand(random);
  const Points points = landmarks(adult_skeleton(), truth);
  LandmarkTargets targets;
  for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i];
  SkeletonFitOptions options{
      .size = truth.size, .size_spread = 0.0, .lengths = truth.lengths, .length_spread = 0.0};
  const auto known = fit_skeleton(adult_skeleton(), targets, options);
  EXPECT_EQ(known->pose.size, truth.size);
  EXPECT_EQ(known->pose.lengths, truth.lengths);
  EXPECT_LT(known->rms_mm, 1.0);
  options = {.size_spread = 0.0, .length_spread = 0.0};
  EXPECT_GT(fit_skeleton(adult_skeleton(), targets, options)->rms_mm, known->rms_mm);
  const auto free = fit_skeleton(adult_skeleton(), targets, {.noise_mm = 0.1});
  for (int i = 0; i < 15; ++i)
    EXPECT_NEAR(free->pose.lengths[i / 3][i % 3], truth.lengths[i / 3][i % 3], 0.03) << i;
}

TEST(SkeletonFit, AnglesThatAreExpectedPullItThere) {
  Random random(7);
  const SkeletonPose truth = some_hand(random);
  const Points points = landmarks(adult_skeleton(), truth);
  LandmarkTargets targets;
  for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i];
  SkeletonFitOptions options{.noise_mm = 1.0};
  options.expected = truth.angles;
  (*options.expected)[HandAngle::index_pip] += 0.5;
  double before = truth.angles[HandAngle::index_pip];
  for (const double deviation : {10.0, 0.1, 0.02, 0.001}) {
    options.expected_rad = deviation;
    const double angle = fit_skeleton(adult_skeleton(), targets, options)->pose.angles[HandAngle::index_pip];
    EXPECT_GT(angle, before - 0.02);
    before = angle;
  }
  EXPECT_NEAR(before, (*options.expected)[HandAngle::index_pip], 0.01);
}

TEST(SkeletonFit, SurfacesAndKnownNumbersAreChecked) {
  const Points points = landmarks(adult_skeleton(), SkeletonPose{});
  LandmarkTargets targets;
  for (int i = 0; i < kSupersetSize; ++i) targets[i].point = points[i];
  const auto fault = [&](const SkeletonFitOptions& options, const HandSurface& surface = {}) {
    return testing::error_of(
        [&] { fit_skeleton(adult_skeleton(), targets, options, std::nullopt, surface); });
  };
  using ::testing::HasSubstr;
  EXPECT_THAT(fault({.surface_mm = 0.0}), HasSubstr("surface_mm is 0"));
  EXPECT_THAT(fault({.bone_mm = -1.0}), HasSubstr("bone_mm is -1"));
  EXPECT_THAT(fault({.overlap_mm = -1.0}), HasSubstr("overlap_mm is -1"));
  EXPECT_THAT(fault({.bone_mm = kNaN}), HasSubstr("bone_mm"));
  EXPECT_THAT(fault({.size = -1.0}), HasSubstr("size is -1"));
  EXPECT_THAT(fault({.length_spread = kNaN}), HasSubstr("length_spread"));
  EXPECT_THAT(fault({.expected_rad = 0.0}), HasSubstr("expected_rad is 0"));
  SkeletonFitOptions options;
  options.lengths[2][1] = 0.0;
  EXPECT_THAT(fault(options), HasSubstr("lengths is 0"));
  EXPECT_THAT(fault({}, {{Point3(0.0, kNaN, 1.0)}}), HasSubstr("a point of the surface is not finite"));
}

}  // namespace
}  // namespace knuckle
