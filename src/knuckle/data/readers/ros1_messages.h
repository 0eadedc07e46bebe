// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "knuckle/data/readers/ros_camera.h"
#include "knuckle/data/readers/ros_image.h"

namespace knuckle {

/// Messages as ROS 1 serialises them: little-endian, without gaps, each text and list after its 32-bit
/// length. All throw an Error that starts with `where` where the bytes end too early.

/// The time of a message that begins with a `std_msgs/Header` [s].
double parse_ros1_stamp(std::span<const std::uint8_t> message, std::string_view where);
/// How many bytes of it are enough for that.
inline constexpr std::uint64_t kRos1StampBytes = 12;

/// A `sensor_msgs/Image`; its pixels are those of `message`.
RosImage parse_ros1_image(std::span<const std::uint8_t> message, std::string_view where);

/// A `sensor_msgs/CameraInfo`.
RosCameraInfo parse_ros1_camera_info(std::span<const std::uint8_t> message, std::string_view where);

/// A `std_msgs/Float32`.
float parse_ros1_float(std::span<const std::uint8_t> message, std::string_view where);

}  // namespace knuckle
