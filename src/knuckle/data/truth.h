// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/camera.h"
#include "knuckle/core/pose.h"

namespace knuckle {

/// Exactly `count` numbers from the text of an annotation; `nan` counts. Throws an Error that starts with
/// `where` and says how many there are, quotes what is not a number, or names one beyond 1e9.
std::vector<double> parse_annotation(std::string_view text, std::size_t count, std::string_view where);

/// Throws an Error that starts with `where` where one of the numbers of a label, [px] or [mm], is infinite or
/// far beyond what any camera sees. NaN, which is not known, passes.
void check_coordinates(std::span<const double> numbers, std::string_view where);

/// Joints from J x (u, v, d). A joint of which any value is not finite, or whose depth is not positive, is
/// missing.
HandPose pose_from_uvd(const Convention& convention, std::span<const double> uvd);

/// Joints from J x (x, y, z) in camera coordinates [mm], y down and z forward.
HandPose pose_from_camera(const Convention& convention, std::span<const double> xyz,
                          const Projection& projection);

/// The joints in camera coordinates [mm], y down and z forward, in the order of the convention; NaN where one
/// is missing.
std::vector<Point3> points_in_camera(const HandPose& pose, const Projection& projection);

/// The pose, or nothing where not one of its joints is known: a frame without truth.
std::optional<HandPose> known_or_nothing(HandPose pose);

/// Moves the joints from the coordinates of one pixel origin to another's (half a pixel).
HandPose with_pixel_origin(HandPose pose, PixelOrigin from, PixelOrigin to);

}  // namespace knuckle
