// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/truth.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr double kLargestNumber = 1e9;  // [px, mm]; beyond it a value is a fault, and its square a risk

}  // namespace

std::vector<double> parse_annotation(std::string_view text, std::size_t count, std::string_view where) {
  std::vector<double> numbers = parse_numbers(text, where);
  if (numbers.size() != count)
    fail("{}: has {} numbers, expected {} ({} joints)", where, numbers.size(), count, count / 3);
  check_coordinates(numbers, where);
  return numbers;
}

void check_coordinates(std::span<const double> numbers, std::string_view where) {
  for (const double number : numbers) {
    if (std::abs(number) > kLargestNumber)
      fail("{}: {} is out of range, expected at most {}", where, number, kLargestNumber);
  }
}

HandPose pose_from_uvd(const Convention& convention, std::span<const double> uvd) {
  assert(uvd.size() == 3 * convention.landmarks.size());
  HandPose pose = HandPose::missing(convention);
  for (std::size_t joint = 0; joint < pose.joints.size(); ++joint) {
    const ImagePoint point{uvd[3 * joint], uvd[3 * joint + 1], uvd[3 * joint + 2]};
    if (!point.is_missing() && point.depth_mm > 0) pose.joints[joint] = point;
  }
  return pose;
}

HandPose pose_from_camera(const Convention& convention, std::span<const double> xyz,
                          const Projection& projection) {
  assert(xyz.size() == 3 * convention.landmarks.size());
  HandPose pose = HandPose::missing(convention);
  for (std::size_t joint = 0; joint < pose.joints.size(); ++joint) {
    const Point3 point(xyz[3 * joint], xyz[3 * joint + 1], xyz[3 * joint + 2]);
    if (point.allFinite()) pose.joints[joint] = projection.to_image(point);
  }
  return pose;
}

std::vector<Point3> points_in_camera(const HandPose& pose, const Projection& projection) {
  std::vector<Point3> points;
  points.reserve(pose.joints.size());
  for (const ImagePoint& joint : pose.joints) {
    points.push_back(joint.is_missing() ? Point3::Constant(kNaN) : projection.to_camera(joint));
  }
  return points;
}

std::optional<HandPose> known_or_nothing(HandPose pose) {
  if (pose.is_missing()) return std::nullopt;
  return pose;
}

HandPose with_pixel_origin(HandPose pose, PixelOrigin from, PixelOrigin to) {
  if (from == to) return pose;
  const double shift = to == PixelOrigin::corner ? 0.5 : -0.5;
  for (ImagePoint& joint : pose.joints) {
    joint.u += shift;
    joint.v += shift;
  }
  return pose;
}

}  // namespace knuckle
