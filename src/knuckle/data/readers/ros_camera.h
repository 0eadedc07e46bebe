// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/camera.h"

namespace knuckle {

/// A `sensor_msgs/CameraInfo`, however it was serialised; without what no depth camera needs.
struct RosCameraInfo {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string distortion_model;  ///< as in "plumb_bob"
  std::vector<double> d;         ///< of that model
  std::array<double, 9> k{};     ///< of the image as it was taken: fx 0 cx, 0 fy cy, 0 0 1
  std::array<double, 12> p{};    ///< of the rectified image, with a fourth column
};

/// The camera of images of a topic: K and D, or P without distortion where the topic's last part begins with
/// "image_rect". Throws an Error that starts with `where` where it was not calibrated, or has a distortion
/// other than plumb_bob's and rational_polynomial's.
Camera camera_of(const RosCameraInfo& info, std::string_view image_topic, std::string_view where);

/// The topic of the camera that belongs to a topic of images: its sibling "camera_info", as ROS has it, or
/// ".../info/camera_info" of RealSense's ".../image/data".
std::string camera_topic_of(std::string_view image_topic);

}  // namespace knuckle
