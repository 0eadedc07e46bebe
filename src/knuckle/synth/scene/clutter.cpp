// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/clutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "knuckle/camera/projection.h"
#include "knuckle/core/angle.h"
#include "knuckle/synth/scene/sampling.h"
#include "knuckle/synth/scene/things.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

constexpr int kThingAttempts = 3;
constexpr float kSkinClearanceMm = 2.0f;

/// Where the ray of a random pixel, most often near the palm, points to: at depth 1 [mm].
Vector3f sampled_ray(const SceneActors& actors, Random& random) {
  constexpr double kNearShare = 0.6;
  constexpr double kNearSpread = 0.18;  // of the image's width
  const Camera& camera = actors.camera;
  const Projection projection(camera);
  const bool is_near = random.uniform() < kNearShare;
  double u = random.uniform(0.0, camera.width - 1.0);
  double v = random.uniform(0.0, camera.height - 1.0);
  if (is_near) {
    const ImagePoint palm = projection.to_image(actors.palm());
    u = std::clamp(palm.u + kNearSpread * camera.width * random.normal(), 0.0, camera.width - 1.0);
    v = std::clamp(palm.v + kNearSpread * camera.width * random.normal(), 0.0, camera.height - 1.0);
  }
  return projection.to_camera(ImagePoint{u, v, 1.0}).cast<float>();
}

/// Where a ray meets the table's top, in the table's axes; nothing where it passes it.
std::optional<Eigen::Vector2f> place_on_table(const Vector3f& ray, const Table& table) {
  const Eigen::Isometry3f table_from_camera = table.camera_from_table.inverse();
  const Vector3f origin = table_from_camera.translation();
  const Vector3f direction = table_from_camera.linear() * ray;
  if (direction.z() >= 0.0f) return std::nullopt;
  const Vector3f place = origin - direction * (origin.z() / direction.z());
  if (!table.top.contains(place.head<2>())) return std::nullopt;
  return Eigen::Vector2f(place.head<2>());
}

/// Radius of the smallest upright cylinder about the z axis around a thing.
float reach_of(const Shape& shape) {
  float reach = 0.0f;
  for (const Vector3f& vertex : shape.mesh.vertices) reach = std::max(reach, vertex.head<2>().norm());
  return reach;
}

/// A circle on the table that is taken.
struct Footprint {
  Eigen::Vector2f centre;
  float radius;
};

bool is_free(const Footprint& wanted, const std::vector<Footprint>& taken) {
  return std::ranges::none_of(taken, [&](const Footprint& other) {
    return (wanted.centre - other.centre).norm() < wanted.radius + other.radius;
  });
}

Shape sampled_any(const SceneOptions& options, Random& random) {
  const std::vector<std::string_view> kinds = allowed_things(options);
  return sampled_thing(kinds[random.below(static_cast<std::uint32_t>(kinds.size()))], random);
}

/// A shelf of boards with boxes on them.
Shape sampled_shelf(Random& random) {
  const float width = between(random, 500, 1100);
  const float depth = between(random, 220, 380);
  const float spacing = between(random, 240, 420);
  constexpr float kBoard = 20.0f;
  Shape shelf;
  const int boards = 3 + static_cast<int>(random.below(4));
  for (int i = 0; i < boards; ++i) {
    const float height = static_cast<float>(i) * spacing;
    shelf.append(box_shape({width, depth, kBoard}), standing({0, 0, height}, Vector3f::UnitZ(), 0.0));
    const Vector3f extents(between(random, 60, 0.8 * width), between(random, 60, 0.9 * depth),
                           between(random, 40, spacing - kBoard - 10.0));
    shelf.append(box_shape(extents), standing({0, 0, height + kBoard}, Vector3f::UnitZ(), 0.0));
  }
  for (const float side : {-0.5f, 0.5f}) {
    shelf.append(box_shape({kBoard, depth, static_cast<float>(boards) * spacing}),
                 standing({side * (width + kBoard), 0, 0}, Vector3f::UnitZ(), 0.0));
  }
  return shelf;
}

Shape sampled_furniture(Random& random) {
  const double kind = random.uniform();
  if (kind < 0.5)
    return box_shape({between(random, 200, 1200), between(random, 200, 700), between(random, 300, 2200)});
  if (kind < 0.8) return sampled_shelf(random);
  const float radius = between(random, 12, 160);
  return cone_shape(radius, radius, between(random, 500, 2200));
}

/// Whether a thing does not reach below or above the table's top.
bool is_beside(const PlacedShape& thing, const Table& table) {
  const Vector3f foot = table.camera_from_table.inverse() * thing.camera_from_shape.translation();
  return table.top.exteriorDistance(Eigen::Vector2f(foot.head<2>())) > reach_of(thing.shape);
}

/// A long thing about the z axis that reaches far beyond the picture on both sides, or on one.
Shape sampled_bar(Random& random) {
  constexpr float kLong = 1500.0f;
  Shape bar;
  const Eigen::Isometry3f middle =
      standing({0, 0, random.uniform() < 0.5 ? -kLong : 0.0f}, Vector3f::UnitZ(), 0.0);
  const float radius = between(random, 2.5, 25);
  if (random.uniform() < 0.6) {
    bar.append(cone_shape(radius, radius, 2.0f * kLong, 12), middle);
  } else {
    bar.append(box_shape({between(random, 20, 120), between(random, 4, 40), 2.0f * kLong}), middle);
  }
  return bar;
}

}  // namespace

std::vector<PlacedShape> things_on_table(const SceneActors& actors, const Table& table,
                                         const SceneOptions& options, Random& random) {
  std::vector<PlacedShape> things;
  std::vector<Footprint> taken;
  const int wanted = static_cast<int>(random.below(static_cast<std::uint32_t>(options.most_things) + 1));
  const bool has_cloth = random.uniform() < options.cloth_share;
  for (int i = 0; i < wanted * kThingAttempts && std::ssize(things) < wanted; ++i) {
    const std::optional<Eigen::Vector2f> foot = place_on_table(sampled_ray(actors, random), table);
    if (!foot) continue;
    PlacedShape thing;
    const bool is_cloth = has_cloth && things.empty();
    thing.shape = is_cloth ? sampled_cloth(random) : sampled_any(options, random);
    const double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
    thing.camera_from_shape =
        table.camera_from_table * standing({foot->x(), foot->y(), 0.0f}, Vector3f::UnitZ(), turn);
    const Footprint footprint{*foot, 0.8f * reach_of(thing.shape)};
    if (!is_free(footprint, taken) || !keeps_clear(thing, actors, kSkinClearanceMm)) continue;
    taken.push_back(footprint);
    things.push_back(std::move(thing));
  }
  return things;
}

std::vector<PlacedShape> furniture(const SceneActors& actors, const Room& room,
                                   const std::optional<Table>& table, const SceneOptions& options,
                                   Random& random) {
  constexpr double kBehindMm = 120.0;
  constexpr double kFarMm = 2500.0;
  std::vector<PlacedShape> pieces;
  const int wanted =
      static_cast<int>(random.below(static_cast<std::uint32_t>(std::min(options.most_things, 5)) + 1));
  const Eigen::Isometry3f room_from_camera = room.camera_from_room.inverse();
  for (int i = 0; i < wanted * kThingAttempts && std::ssize(pieces) < wanted; ++i) {
    const double far = random.uniform();
    const auto depth = static_cast<float>(actors.palm().z() + kBehindMm + kFarMm * far * far);
    const Vector3f place = room_from_camera * (sampled_ray(actors, random) * depth);
    PlacedShape piece;
    piece.shape = sampled_furniture(random);
    piece.camera_from_shape =
        room.camera_from_room * standing({place.x(), place.y(), 0.0f}, Vector3f::UnitZ(), 0.0);
    const bool is_apart = !table || is_beside(piece, *table);
    if (is_apart && room.inside.contains(place) && keeps_clear(piece, actors, kSkinClearanceMm))
      pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::optional<PlacedShape> thing_before_hand(const SceneActors& actors, Random& random) {
  constexpr int kAttempts = 6;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const Point3& aim = actors.landmarks[random.below(kSupersetSize)];
    const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
    Eigen::Vector3f along(static_cast<float>(random.normal()), static_cast<float>(random.normal()),
                          0.4f * static_cast<float>(random.normal()));
    if (along.norm() < 0.1f) continue;
    const auto place = (random.uniform(0.45, 0.92) * aim).eval();
    PlacedShape thing{sampled_bar(random), standing(place.cast<float>(), along.normalized(), angle)};
    if (keeps_clear(thing, actors, kSkinClearanceMm)) return thing;
  }
  return std::nullopt;
}

}  // namespace knuckle
