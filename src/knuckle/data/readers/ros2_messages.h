// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "knuckle/data/readers/ros_camera.h"
#include "knuckle/data/readers/ros_image.h"

namespace knuckle {

/// Messages as ROS 2 serialises them: in CDR. All throw an Error that starts with `where` where the bytes are
/// no CDR, or end too early.

/// The time of a message that begins with a `std_msgs/msg/Header` [s]; its first 12 bytes are enough.
double parse_ros2_stamp(std::span<const std::uint8_t> message, std::string_view where);

/// A `sensor_msgs/msg/Image`; its pixels are those of `message`.
RosImage parse_ros2_image(std::span<const std::uint8_t> message, std::string_view where);

/// A `sensor_msgs/msg/CameraInfo`.
RosCameraInfo parse_ros2_camera_info(std::span<const std::uint8_t> message, std::string_view where);

}  // namespace knuckle
