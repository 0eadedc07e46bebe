// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/things.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "knuckle/core/angle.h"
#include "knuckle/core/error.h"
#include "knuckle/core/portable_math.h"
#include "knuckle/hand/rotation_between.h"
#include "knuckle/synth/scene/sampling.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

Eigen::Isometry3f moved_by(const Vector3f& shift) {
  Eigen::Isometry3f place = Eigen::Isometry3f::Identity();
  place.translation() = shift;
  return place;
}

/// Turned about x by `angle`, then moved.
Eigen::Isometry3f tilted(double angle, const Vector3f& shift) {
  Eigen::Isometry3f place = moved_by(shift);
  place.linear() = rotation_about(angle, Eigen::Vector3d::UnitX()).toRotationMatrix().cast<float>();
  return place;
}

/// A turned thing whose contacts are those of some frustums: radius at the bottom, at the top, and from
/// which height to which.
struct Band {
  float bottom_radius;
  float top_radius;
  float from;
  float to;
};

Shape turned_shape(std::span<const ProfilePoint> outline, std::span<const Band> bands) {
  constexpr int kSides = 20;
  Shape shape;
  shape.mesh = turned(outline, kSides);
  for (const Band& band : bands) {
    Solid solid{Solid::Kind::cone,
                {band.bottom_radius, band.top_radius, 0.5f * (band.to - band.from)},
                moved_by({0.0f, 0.0f, 0.5f * (band.from + band.to)})};
    shape.solids.push_back(solid);
  }
  return shape;
}

Shape sampled_box(Random& random) {
  return box_shape({between(random, 40, 220), between(random, 30, 160), between(random, 25, 240)});
}

Shape sampled_block(Random& random) {
  const float side = between(random, 22, 75);
  return box_shape({side, side * between(random, 0.8, 1.0), side * between(random, 0.6, 1.4)});
}

Shape sampled_book(Random& random) {
  return box_shape({between(random, 110, 230), between(random, 150, 310), between(random, 6, 50)});
}

Shape sampled_phone(Random& random) {
  return box_shape({between(random, 62, 82), between(random, 130, 170), between(random, 7, 12)});
}

Shape sampled_keyboard(Random& random) {
  return box_shape({between(random, 280, 450), between(random, 110, 160), between(random, 12, 30)});
}

Shape sampled_can(Random& random) {
  const float radius = between(random, 24, 50);
  return cone_shape(radius, radius, between(random, 40, 180));
}

Shape sampled_glass(Random& random) {
  constexpr float kWall = 3.0f;
  const float bottom = between(random, 22, 34);
  const float top = bottom + between(random, 0, 14);
  const float height = between(random, 80, 160);
  const std::array<ProfilePoint, 6> outline = {
      {{0, 0}, {bottom, 0}, {top, height}, {top - kWall, height}, {bottom - kWall, 6.0f}, {0, 6.0f}}};
  const std::array<Band, 1> bands = {{{bottom, top, 0, height}}};
  return turned_shape(outline, bands);
}

Shape sampled_bowl(Random& random) {
  const float top = between(random, 55, 125);
  const float foot = top * between(random, 0.35, 0.6);
  const float height = top * between(random, 0.35, 0.8);
  const float belly = foot + 0.75f * (top - foot);
  const std::array<ProfilePoint, 7> outline = {{{0, 0},
                                                {foot, 0},
                                                {belly, 0.4f * height},
                                                {top, height},
                                                {top - 4, height},
                                                {belly - 5, 0.4f * height + 3},
                                                {0, 6}}};
  const std::array<Band, 2> bands = {{{foot, belly, 0, 0.4f * height}, {belly, top, 0.4f * height, height}}};
  return turned_shape(outline, bands);
}

Shape sampled_bottle(Random& random) {
  const float radius = between(random, 24, 48);
  const float body = between(random, 90, 210);
  const float neck = radius * between(random, 0.28, 0.5);
  const float shoulder = between(random, 20, 60);
  const float top = between(random, 15, 60);
  const std::array<ProfilePoint, 6> outline = {{{0, 0},
                                                {radius, 0},
                                                {radius, body},
                                                {neck, body + shoulder},
                                                {neck, body + shoulder + top},
                                                {0, body + shoulder + top}}};
  const std::array<Band, 3> bands = {{{radius, radius, 0, body},
                                      {radius, neck, body, body + shoulder},
                                      {neck, neck, body + shoulder, body + shoulder + top}}};
  return turned_shape(outline, bands);
}

/// A handle: half a ring beside the z axis, from height `low` to `high`.
void add_handle(Shape& shape, float at_radius, float low, float high, float reach, float thickness) {
  constexpr int kParts = 8;
  std::vector<Vector3f> line;
  for (int i = 0; i <= kParts; ++i) {
    const double angle = std::numbers::pi * i / kParts;
    line.emplace_back(at_radius - 3.0f + reach * static_cast<float>(portable_sin(angle)), 0.0f,
                      0.5f * (low + high) - 0.5f * (high - low) * static_cast<float>(portable_cos(angle)));
  }
  shape.mesh.append(tube(line, thickness, 8), Eigen::Isometry3f::Identity());
  for (std::size_t i = 1; i < line.size(); ++i) {
    constexpr float kBend = 3.0f;  // rings at bends stand aslant [mm]
    const float half = 0.5f * (line[i] - line[i - 1]).norm();
    const float radius = std::sqrt(half * half + thickness * thickness) + kBend;
    shape.solids.push_back(
        {Solid::Kind::ball, Vector3f::Constant(radius), moved_by(0.5f * (line[i] + line[i - 1]))});
  }
}

Shape sampled_mug(Random& random) {
  const float radius = between(random, 34, 50);
  const float height = between(random, 70, 125);
  constexpr float kWall = 4.0f;
  const std::array<ProfilePoint, 6> outline = {
      {{0, 0}, {radius, 0}, {radius, height}, {radius - kWall, height}, {radius - kWall, 8}, {0, 8}}};
  const std::array<Band, 1> bands = {{{radius, radius, 0, height}}};
  Shape shape = turned_shape(outline, bands);
  add_handle(shape, radius, 0.18f * height, 0.85f * height, between(random, 22, 36), between(random, 4, 7));
  return shape;
}

/// A can that lies about y, as pens and rolls do.
Shape lying(const Shape& standing_shape, float radius) {
  Shape shape;
  shape.append(standing_shape, tilted(-90.0 * kDegree, {0.0f, 0.0f, radius}));
  return shape;
}

Shape sampled_pen(Random& random) {
  const float radius = between(random, 3.5, 8);
  return lying(cone_shape(radius, radius, between(random, 110, 190), 10), radius);
}

Shape sampled_roll(Random& random) {
  const float radius = between(random, 15, 55);
  return lying(cone_shape(radius, radius, between(random, 60, 260)), radius);
}

Shape sampled_ball(Random& random) {
  return ball_shape(between(random, 14, 75));
}

Shape sampled_laptop(Random& random) {
  const float width = between(random, 270, 390);
  const float depth = between(random, 190, 270);
  Shape shape = box_shape({width, depth, 14});
  shape.append(box_shape({width, depth, 8}),
               tilted(random.uniform(60.0, 88.0) * kDegree, {0.0f, 0.5f * depth, 14.0f}) *
                   moved_by({0.0f, 0.5f * depth, 0.0f}));
  return shape;
}

Shape sampled_lamp(Random& random) {
  const float foot = between(random, 50, 100);
  const float height = between(random, 250, 500);
  Shape shape = cone_shape(foot, foot * 0.9f, 20);
  shape.append(cone_shape(7, 7, height, 10), moved_by({0, 0, 20}));
  const float shade = between(random, 50, 120);
  shape.append(cone_shape(shade, 0.6f * shade, between(random, 80, 160)), moved_by({0, 0, height}));
  return shape;
}

Shape sampled_stack(Random& random) {
  Shape shape;
  float height = 0.0f;
  const int count = 2 + static_cast<int>(random.below(4));
  for (int i = 0; i < count; ++i) {
    const Vector3f extents(between(random, 80, 200), between(random, 80, 200), between(random, 10, 45));
    shape.append(box_shape(extents), standing({between(random, -10, 10), between(random, -10, 10), height},
                                              Vector3f::UnitZ(), random.uniform(0.0, std::numbers::pi)));
    height += extents.z();
  }
  return shape;
}

Shape sampled_jug(Random& random) {
  const float radius = between(random, 45, 75);
  const float height = between(random, 140, 240);
  const float neck = radius * between(random, 0.5, 0.8);
  const std::array<ProfilePoint, 7> outline = {{{0, 0},
                                                {0.75f * radius, 0},
                                                {radius, 0.4f * height},
                                                {neck, height},
                                                {neck - 4, height},
                                                {radius - 6, 0.4f * height},
                                                {0, 8}}};
  const std::array<Band, 2> bands = {
      {{0.75f * radius, radius, 0, 0.4f * height}, {radius, neck, 0.4f * height, height}}};
  Shape shape = turned_shape(outline, bands);
  add_handle(shape, neck, 0.35f * height, 0.9f * height, between(random, 45, 70), between(random, 6, 10));
  return shape;
}

struct Kind {
  std::string_view name;
  Shape (*make)(Random&);
};

constexpr std::array<Kind, 17> kKinds = {{{"box", sampled_box},
                                          {"block", sampled_block},
                                          {"book", sampled_book},
                                          {"phone", sampled_phone},
                                          {"keyboard", sampled_keyboard},
                                          {"can", sampled_can},
                                          {"glass", sampled_glass},
                                          {"bowl", sampled_bowl},
                                          {"bottle", sampled_bottle},
                                          {"mug", sampled_mug},
                                          {"pen", sampled_pen},
                                          {"roll", sampled_roll},
                                          {"ball", sampled_ball},
                                          {"laptop", sampled_laptop},
                                          {"lamp", sampled_lamp},
                                          {"stack", sampled_stack},
                                          {"jug", sampled_jug}}};

}  // namespace

std::span<const std::string_view> thing_kinds() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const Kind& kind : kKinds) all.push_back(kind.name);
    return all;
  }();
  return names;
}

Shape sampled_thing(std::string_view name, Random& random) {
  const auto kind = std::ranges::find(kKinds, name, &Kind::name);
  if (kind == kKinds.end()) fail("things: '{}' is not a kind of thing", name);
  return kind->make(random);
}

Shape sampled_cloth(Random& random) {
  constexpr int kCells = 24;
  constexpr int kWaves = 5;
  const float extent = between(random, 150, 420);
  const float depth = between(random, 4, 28);
  struct Wave {
    float x, y, phase, height;
  };
  std::array<Wave, kWaves> waves{};
  for (Wave& wave : waves) {
    wave = {between(random, -9, 9) / extent, between(random, -9, 9) / extent,
            between(random, 0, 2.0 * std::numbers::pi), depth / kWaves};
  }
  Shape shape;
  for (int row = 0; row <= kCells; ++row) {
    for (int column = 0; column <= kCells; ++column) {
      const float x = extent * (static_cast<float>(column) / kCells - 0.5f);
      const float y = extent * (static_cast<float>(row) / kCells - 0.5f);
      float height = 1.5f;
      for (const Wave& wave : waves) {
        const double phase = wave.x * x + wave.y * y + wave.phase;
        height += wave.height * (1.0f + static_cast<float>(portable_sin(phase)));
      }
      const bool is_border = row == 0 || column == 0 || row == kCells || column == kCells;
      shape.mesh.vertices.emplace_back(x, y, is_border ? 0.5f : height);
    }
  }
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const int corner = row * (kCells + 1) + column;
      shape.mesh.add_face(corner, corner + 1, corner + kCells + 2);
      shape.mesh.add_face(corner, corner + kCells + 2, corner + kCells + 1);
    }
  }
  Solid solid{
      Solid::Kind::box, {0.5f * extent, 0.5f * extent, 2.0f * depth + 2.0f}, Eigen::Isometry3f::Identity()};
  shape.solids.push_back(solid);
  return shape;
}

}  // namespace knuckle
