// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "knuckle/core/angle.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/hand/hand_rig.h"
#include "knuckle/hand/rotation_between.h"
#include "knuckle/synth/scene/sampling.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

constexpr int kTableAttempts = 12;
/// Skin that is this far from the palm lies on the table with the hand [mm].
constexpr float kRestingReach = 280.0f;
/// What presses on the table may sink in so far: skin yields [mm].
constexpr float kYield = 1.5f;

/// Skin that may touch the table: the hand and the near half of the forearm.
std::vector<Vector3f> resting_points(const SceneActors& actors) {
  constexpr std::size_t kStride = 4;
  const Vector3f palm = actors.palm().cast<float>();
  std::vector<Vector3f> points;
  for (std::size_t i = 0; i < actors.points.size(); i += kStride) {
    if ((actors.points[i] - palm).squaredNorm() < kRestingReach * kRestingReach)
      points.push_back(actors.points[i]);
  }
  return points;
}

float lowest(std::span<const Vector3f> points, const Vector3f& up) {
  float least = std::numeric_limits<float>::infinity();
  for (const Vector3f& point : points) least = std::min(least, up.dot(point));
  return least;
}

Vector3f turned_aside(const Vector3f& direction, double deviation_deg, Random& random) {
  const Vector3f shift = normal_vector(random);
  return (direction + static_cast<float>(deviation_deg * kDegree) * shift).normalized();
}

/// Which way is up for a hand that lies on its palm, its little finger's side, or its back.
Vector3f sampled_side(const SceneActors& actors, Random& random) {
  const Eigen::Matrix3f axes = hand_axes(actors.landmarks).cast<float>();
  Vector3f to_camera = -actors.palm().normalized().cast<float>();
  constexpr float kGrazing = 0.2f;
  const std::array<Vector3f, 3> sides = {-axes.col(2), axes.col(0), axes.col(2)};
  const double draw = random.uniform();
  const std::size_t first = draw < 0.65 ? 0 : draw < 0.85 ? 1 : 2;
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const Vector3f& side = sides[(first + i) % sides.size()];
    if (side.dot(to_camera) > kGrazing) return side;
  }
  return to_camera;
}

/// A table's axes: up, and away from the person.
Eigen::Matrix3f table_axes(const SceneActors& actors, const Vector3f& up, Random& random) {
  const Vector3f from_elbow = (actors.palm() - actors.elbow).cast<float>();
  Vector3f away = from_elbow - up * up.dot(from_elbow);
  if (away.norm() < 1.0f) away = up.cross(Vector3f::UnitX());
  const Eigen::Matrix3f turn =
      rotation_about(25.0 * kDegree * random.normal(), up.cast<double>()).toRotationMatrix().cast<float>();
  away = (turn * away).normalized();
  Eigen::Matrix3f axes;
  axes << away.cross(up), away, up;
  return axes;
}

/// One try; nothing where the camera does not look down on it.
std::optional<Table> proposed_table(const SceneActors& actors, std::span<const Vector3f> points,
                                    bool is_resting, Random& random) {
  const Vector3f palm = actors.palm().cast<float>();
  const Vector3f up = is_resting ? resting_up(points, palm, sampled_side(actors, random), random)
                                 : turned_aside(actors.up, 3.0, random);
  const double gap = is_resting ? -kYield : 5.0 + 250.0 * random.uniform() * random.uniform();
  const float level = lowest(points, up) - static_cast<float>(gap);
  const float camera_height = -level;
  constexpr float kLeastHeight = 60.0f;
  constexpr float kLeastSlope = 0.12f;
  if (camera_height < std::max(kLeastHeight, kLeastSlope * palm.norm())) return std::nullopt;
  Table table;
  table.camera_from_table.linear() = table_axes(actors, up, random);
  table.camera_from_table.translation() = palm - up * (up.dot(palm) - level);
  table.thickness = between(random, 15, 45);
  table.height = between(random, 450, 1000);
  table.top.min() = {-between(random, 120, 900), -between(random, is_resting ? 120 : 60, 450)};
  table.top.max() = {between(random, 120, 900), between(random, 120, 900)};
  return table;
}

}  // namespace

Vector3f resting_up(std::span<const Vector3f> points, const Vector3f& middle, const Vector3f& up,
                    Random& random) {
  constexpr int kDirections = 24;
  constexpr double kDeviationDeg = 14.0;
  Vector3f best = up;
  float least = std::numeric_limits<float>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const Vector3f direction = i == 0 ? up : turned_aside(up, kDeviationDeg, random);
    const float height = direction.dot(middle) - lowest(points, direction);
    if (height < least) {
      least = height;
      best = direction;
    }
  }
  return best;
}

std::optional<Table> sampled_table(const SceneActors& actors, const SceneOptions& options, Random& random) {
  const std::vector<Vector3f> points = resting_points(actors);
  const bool is_resting = random.uniform() < options.rest_share;
  for (int attempt = 0; attempt < kTableAttempts; ++attempt) {
    std::optional<Table> table = proposed_table(actors, points, is_resting, random);
    if (table && keeps_clear(shape_of(*table), actors, -2.0f * kYield)) return table;
  }
  return std::nullopt;
}

PlacedShape shape_of(const Table& table) {
  constexpr float kLeg = 50.0f;
  const Eigen::Vector2f extents = table.top.sizes();
  const Eigen::Vector2f middle = table.top.center();
  Eigen::Isometry3f place = Eigen::Isometry3f::Identity();
  place.translation() = Vector3f(middle.x(), middle.y(), -table.thickness);
  PlacedShape placed;
  placed.camera_from_shape = table.camera_from_table;
  placed.shape.append(box_shape({extents.x(), extents.y(), table.thickness}), place);
  for (const float x : {table.top.min().x() + kLeg, table.top.max().x() - kLeg}) {
    for (const float y : {table.top.min().y() + kLeg, table.top.max().y() - kLeg}) {
      place.translation() = Vector3f(x, y, -table.height);
      placed.shape.append(box_shape({kLeg, kLeg, table.height - table.thickness}), place);
    }
  }
  return placed;
}

}  // namespace knuckle
