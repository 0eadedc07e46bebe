// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people/hand_proportions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/hand/hand_rig.h"

namespace knuckle {
namespace {

using Eigen::Affine3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::string_view kSide = ".R";

Vector3d joint(const ShapedBody& person, int bone) {
  return person.joints[bone].cast<double>();
}

Vector3d landmark(const ShapedBody& person, Landmark which) {
  return person.landmarks[static_cast<std::size_t>(which)].cast<double>();
}

/// x -> origin + linear (x - fixed).
Affine3d about(const Vector3d& fixed, const Matrix3d& linear, const Vector3d& origin) {
  Affine3d map = Affine3d::Identity();
  map.linear() = linear;
  map.translation() = origin - linear * fixed;
  return map;
}

/// Stretches along a direction of length 1 and across it.
Matrix3d stretch(const Vector3d& along, double length, double thickness) {
  return thickness * Matrix3d::Identity() + (length - thickness) * along * along.transpose();
}

Matrix3d stretch(const Matrix3d& axes, const Vector3d& factors) {
  return axes * factors.asDiagonal() * axes.transpose();
}

/// What each bone of the body does to points at rest; nothing for bones outside of the hand.
using BoneMaps = std::vector<std::optional<Affine3d>>;

/// The palm grows about the wrist: its bones keep together.
void add_palm(BoneMaps& maps, const ShapedBody& person, const HandProportions& proportions) {
  const Body& body = *person.body;
  const int wrist = body.bone(fmt::format("wrist{}", kSide));
  const Vector3d centre = joint(person, wrist);
  const Matrix3d axes = hand_axes(centre, joint(person, body.bone(finger_bone(1, 0, kSide))),
                                  joint(person, body.bone(finger_bone(2, 0, kSide))),
                                  joint(person, body.bone(finger_bone(4, 0, kSide))));
  const auto map = [&](double ray) {
    const Vector3d factors(proportions.palm_breadth, proportions.palm_length * ray, 1.0);
    return about(centre, stretch(axes, factors), centre);
  };
  maps[wrist] = map(1.0);
  for (int finger = 1; finger < kFingers; ++finger) {
    const int metacarpal = body.parents[body.bone(finger_bone(finger, 0, kSide))];
    if (metacarpal >= 0 && metacarpal != wrist) maps[metacarpal] = map(proportions.ray_lengths[finger]);
  }
}

void add_digit(BoneMaps& maps, const ShapedBody& person, const HandProportions& proportions, int finger) {
  const Body& body = *person.body;
  const Vector3d tip =
      landmark(person, static_cast<Landmark>(static_cast<int>(Landmark::thumb_tip) + 4 * finger));
  for (int part = 0; part < 3; ++part) {
    const int bone = body.bone(finger_bone(finger, part, kSide));
    const Vector3d head = joint(person, bone);
    const Vector3d end = part < 2 ? joint(person, body.bone(finger_bone(finger, part + 1, kSide))) : tip;
    const Affine3d& parent = *maps[body.parents[bone]];
    maps[bone] = about(head,
                       stretch((end - head).normalized(), proportions.bone_lengths[finger][part],
                               proportions.thicknesses[finger]),
                       parent * head);
  }
}

BoneMaps bone_maps(const ShapedBody& person, const HandProportions& proportions) {
  BoneMaps maps(person.joints.size());
  add_palm(maps, person, proportions);
  for (int finger = 0; finger < kFingers; ++finger) add_digit(maps, person, proportions, finger);
  return maps;
}

/// Where a vertex goes: the mean of where its bones take it.
Vector3d moved(const Body& body, std::size_t vertex, const Vector3d& point, const BoneMaps& maps) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < Body::kBonesPerVertex; ++k) {
    const auto& map = maps[body.weight_bones[vertex][k]];
    sum += body.weights[vertex][k] * (map ? *map * point : point);
  }
  return sum;
}

}  // namespace

HandProportions sampled_proportions(double deviation, Random& random) {
  const auto factor = [&](double share) {
    constexpr double kFarthest = 2.5;
    return 1.0 + share * deviation * std::clamp(random.normal(), -kFarthest, kFarthest);
  };
  HandProportions proportions;
  proportions.palm_length = factor(0.7);
  for (int finger = 0; finger < kFingers; ++finger) {
    proportions.ray_lengths[finger] = factor(0.5);
    proportions.thicknesses[finger] = factor(0.5);
    const double digit = factor(0.7);
    for (double& bone : proportions.bone_lengths[finger]) bone = digit * factor(1.0);
  }
  return proportions;
}

ShapedBody with_proportions(ShapedBody person, const HandProportions& proportions) {
  const Body& body = *person.body;
  const BoneMaps maps = bone_maps(person, proportions);
  for (std::size_t i = 0; i < person.vertices.size(); ++i) {
    const bool is_moved =
        std::ranges::any_of(body.weight_bones[i], [&](std::int32_t bone) { return maps[bone].has_value(); });
    if (is_moved) person.vertices[i] = moved(body, i, person.vertices[i].cast<double>(), maps).cast<float>();
  }
  find_joints(person);
  return person;
}

double hand_breadth_mm(const ShapedBody& person) {
  const Body& body = *person.body;
  const Vector3d index = landmark(person, Landmark::index_mcp);
  const Vector3d little = landmark(person, Landmark::little_mcp);
  const Matrix3d axes =
      hand_axes(landmark(person, Landmark::wrist), index, landmark(person, Landmark::middle_mcp), little);
  const Vector3d across = (index - little).normalized();
  const Vector3d normal = across.cross(axes.col(2)).normalized();  // of the plane that cuts the knuckles
  const auto is_of_thumb = [&](std::int32_t vertex) {
    const std::string& name = body.names[body.weight_bones[vertex][0]];
    return name.starts_with("finger1");
  };
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (std::size_t f = 0; f < body.faces.size(); ++f) {
    if (body.is_hand[f] == 0) continue;
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = body.faces[f][k];
      const std::int32_t to = body.faces[f][(k + 1) % 3];
      if (is_of_thumb(from) || is_of_thumb(to)) continue;
      const Vector3d a = person.vertices[from].cast<double>() - little;
      const Vector3d b = person.vertices[to].cast<double>() - little;
      const double above = normal.dot(a);
      const double below = normal.dot(b);
      if ((above < 0.0) == (below < 0.0)) continue;
      const double place = across.dot(a + (b - a) * (above / (above - below)));
      least = std::min(least, place);
      most = std::max(most, place);
    }
  }
  if (!(most > least)) fail("hand breadth: the knuckles have no skin");
  return most - least;
}

}  // namespace knuckle
