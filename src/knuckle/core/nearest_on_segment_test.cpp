// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/nearest_on_segment.h"

#include <algorithm>
#include <limits>

#include <Eigen/Core>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

TEST(NearestOnSegment, IsTheFootOfThePerpendicularOrAnEnd) {
  const Vector2d from(1.0, 2.0);
  const Vector2d to(5.0, 2.0);
  EXPECT_EQ(nearest_share(Vector2d(2.0, 7.0), from, to), 0.25);
  EXPECT_EQ(nearest_share(Vector2d(2.0, 7.0), to, from), 0.75);
  EXPECT_EQ(nearest_share(Vector2d(-3.0, 2.0), from, to), 0.0) << "before the first end";
  EXPECT_EQ(nearest_share(Vector2d(9.0, -1.0), from, to), 1.0) << "beyond the second";
}

TEST(NearestOnSegment, IsTheFirstEndWhereBothAreOnePoint) {
  const Vector3d end(1.0, 2.0, 3.0);
  EXPECT_EQ(nearest_share(Vector3d(4.0, 5.0, 6.0), end, end), 0.0);
}

TEST(NearestOnSegment, NoPlaceOfManyIsNearer) {
  Random random(7);
  const auto draw = [&] {
    return Vector3d(random.uniform(-50.0, 50.0), random.uniform(-50.0, 50.0), random.uniform(-50.0, 50.0));
  };
  constexpr int kPlaces = 1000;
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3d point = draw();
    const Vector3d from = draw();
    const Vector3d to = draw();
    const auto distance = [&](double share) { return (point - from - share * (to - from)).norm(); };
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kPlaces; ++i) least = std::min(least, distance(1.0 * i / kPlaces));
    const double found = distance(nearest_share(point, from, to));
    EXPECT_LE(found, least + 1e-9);
    EXPECT_GE(found, least - (to - from).norm() / kPlaces);
  }
}

}  // namespace
}  // namespace knuckle
