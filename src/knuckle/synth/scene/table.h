// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "knuckle/core/random.h"
#include "knuckle/synth/scene/contacts.h"
#include "knuckle/synth/scene/scene_options.h"

namespace knuckle {

/// A table top. In its own axes z is up, y away from the person, and the origin lies on it below the palm.
struct Table {
  Eigen::Isometry3f camera_from_table = Eigen::Isometry3f::Identity();
  Eigen::AlignedBox2f top;  ///< how far it reaches [mm]
  float thickness = 25.0f;  ///< [mm]
  float height = 720.0f;    ///< above the floor [mm]

  Eigen::Vector3f up() const { return camera_from_table.linear().col(2); }
};

/// A table below the hand that the camera sees from above; the hand is above it, or lies on it. Nothing where
/// 12 random ones cannot be.
std::optional<Table> sampled_table(const SceneActors& actors, const SceneOptions& options, Random& random);

/// Which way is up for skin that has come to rest on a plane: of some directions about `up`, that in which
/// `middle` lies least above the lowest of the points. All of length 1.
Eigen::Vector3f resting_up(std::span<const Eigen::Vector3f> points, const Eigen::Vector3f& middle,
                           const Eigen::Vector3f& up, Random& random);

/// Top and legs.
PlacedShape shape_of(const Table& table);

}  // namespace knuckle
