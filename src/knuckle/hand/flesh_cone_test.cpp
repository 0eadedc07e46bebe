// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/flesh_cone.h"

#include <algorithm>

#include "knuckle/core/testing.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/hand_flesh.h"
#include "knuckle/hand/skeleton_testing.h"
#include "knuckle/hand/surface_contacts.h"

namespace knuckle {
namespace {

using testing::random_direction;

Point3 random_point(Random& random, double extent) {
  return {random.uniform(-extent, extent), random.uniform(-extent, extent), random.uniform(-extent, extent)};
}

/// Cones of all kinds: even, growing, shrinking, and ends that hold the other.
FleshCone random_cone(Random& random) {
  const Point3 from = random_point(random, 40.0);
  const Point3 to = random.below(4) == 0 ? from + random_point(random, 8.0) : random_point(random, 40.0);
  return {from, random.uniform(2.0, 30.0), to, random.uniform(2.0, 30.0)};
}

/// Where the ray enters one of very many spheres along the cone; infinite where it meets none.
double brute_force_entry(const FleshCone& cone, const Point3& origin, const Eigen::Vector3d& direction) {
  double first = std::numeric_limits<double>::infinity();
  constexpr int kSpheres = 5000;
  for (int i = 0; i <= kSpheres; ++i) {
    const double share = static_cast<double>(i) / kSpheres;
    const Point3 centre = (1.0 - share) * cone.from + share * cone.to;
    const double radius = (1.0 - share) * cone.radius_from + share * cone.radius_to;
    const Eigen::Vector3d away = origin - centre;
    const double a = direction.squaredNorm();
    const double b = away.dot(direction);
    const double root = b * b - a * (away.squaredNorm() - radius * radius);
    if (root >= 0.0) first = std::min(first, (-b - std::sqrt(root)) / a);
  }
  return first;
}

double distance_to(const std::vector<FleshCone>& cones, const Point3& point) {
  double least = std::numeric_limits<double>::infinity();
  for (const FleshCone& cone : cones) {
    for (int i = 0; i <= 400; ++i) {
      const double share = i / 400.0;
      const Point3 centre = (1.0 - share) * cone.from + share * cone.to;
      const double radius = (1.0 - share) * cone.radius_from + share * cone.radius_to;
      least = std::min(least, (point - centre).norm() - radius);
    }
  }
  return least;
}

TEST(FleshCone, ARayEntersWhereItEntersTheFirstOfAllSpheresAlongIt) {
  Random random(5);
  int hits = 0;
  int passes = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    const FleshCone cone = random_cone(random);
    const Point3 origin = 300.0 * random_direction(random);
    const Eigen::Vector3d direction =
        random.uniform(0.1, 3.0) * (random_point(random, 50.0) - origin).normalized();
    const double expected = brute_force_entry(cone, origin, direction);
    const auto hit = first_hit(cone, origin, direction);
    if (!std::isfinite(expected)) {
      ++passes;
      EXPECT_FALSE(hit && std::isfinite(hit->distance) &&
                   distance_to({cone}, origin + hit->distance * direction) > 0.01);
      continue;
    }
    ++hits;
    ASSERT_TRUE(hit) << trial;
    EXPECT_NEAR(hit->distance * direction.norm(), expected * direction.norm(), 0.05) << trial;
    EXPECT_NEAR(hit->normal.norm(), 1.0, 1e-9);
    EXPECT_LT(hit->normal.dot(direction), 1e-9) << "the skin faces where the ray comes from";
    // One millimetre along the normal is one millimetre away.
    EXPECT_NEAR(distance_to({cone}, origin + hit->distance * direction + hit->normal), 1.0, 0.01) << trial;
  }
  EXPECT_GT(hits, 100);
  EXPECT_GT(passes, 50);
}

TEST(FleshCone, WhatLiesBehindTheRayIsNotMet) {
  const FleshCone cone{{0, 0, 50}, 10.0, {30, 0, 50}, 8.0};
  EXPECT_TRUE(first_hit(cone, Point3::Zero(), Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(first_hit(cone, Point3::Zero(), -Eigen::Vector3d::UnitZ()));
  const FleshCone ball{{0, 0, 50}, 10.0, {0, 0, 50}, 10.0};
  const auto hit = first_hit(ball, Point3::Zero(), Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->distance, 40.0, 1e-12);
}

TEST(FleshCone, AHandsConesAreTheFleshThatItIsFittedBy) {
  Random random(3, 4);
  SupersetPoints points =
      landmarks(adult_skeleton(), HandAngles{}, RigidTransform(Eigen::Translation3d(10.0, 20.0, 500.0)));
  const std::vector<FleshCone> cones = flesh_cones(points);
  ASSERT_EQ(cones.size(), static_cast<std::size_t>(kFleshCount));
  const PosedFlesh posed(points, palm_length(points));
  for (int i = 0; i < 50; ++i) {
    const Point3 point(10.0 + random.uniform(-90, 90), 20.0 + random.uniform(-200, 60),
                       500.0 + random.uniform(-60, 60));
    EXPECT_NEAR(distance_to(cones, point), posed.nearest(point).gap_mm, 0.05);
  }
  points[static_cast<std::size_t>(Landmark::index_tip)] = Point3::Constant(kNaN);
  EXPECT_EQ(flesh_cones(points).size(), cones.size() - 1);
  points[static_cast<std::size_t>(Landmark::wrist)] = Point3::Constant(kNaN);
  EXPECT_TRUE(flesh_cones(points).empty());
}

}  // namespace
}  // namespace knuckle
