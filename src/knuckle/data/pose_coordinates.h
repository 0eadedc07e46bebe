// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "knuckle/camera/projection.h"

namespace knuckle {

/// What the three numbers of a joint are in a poses file, which another program may have written.
struct PoseCoordinates {
  enum class Kind : std::uint8_t { uvd, xyz };

  Kind kind = Kind::uvd;  ///< u, v [px] and depth, or a point in camera coordinates
  /// Of x y z: column k is the direction in which a file's k-th number grows, in our axes (x right, y down,
  /// z forward).
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  double unit_mm = 1.0;  ///< of the depth, or of x, y and z

  bool operator==(const PoseCoordinates& other) const {
    return kind == other.kind && axes == other.axes && unit_mm == other.unit_mm;
  }
};

/// "uvd" or "xyz", with blanks or without. Throws an Error that quotes any other text.
PoseCoordinates::Kind coordinate_kind_from_text(std::string_view text);

/// Where each of the three numbers points, as in "x,-y,-z" (x right, y up, z towards the viewer, as OpenGL
/// has it). Each axis must stand there once. Throws an Error that quotes a faulty text.
Eigen::Matrix3d axes_from_text(std::string_view text);

/// "mm", "cm" or "m", in millimetres. Throws an Error that quotes any other text.
double unit_from_text(std::string_view text);

/// The options that say these coordinates: "--format xyz --axes x,-y,-z --unit m"; without those that say
/// what is usual.
std::string as_options(const PoseCoordinates& coordinates);

/// A joint in our pixel-centre coordinates, from its three numbers; missing where one of them is NaN or, of
/// x y z, where it lies behind a projective camera. Of u v d the camera is not looked at.
ImagePoint image_point(const Eigen::Vector3d& numbers, const PoseCoordinates& coordinates,
                       const Projection* projection);

}  // namespace knuckle
