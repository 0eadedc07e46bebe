// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/data/readers/ros_source.h"

namespace knuckle {

/// Settings of a `rosbag:` source.
using RosbagOptions = RosOptions;

/// Depth of a ROS 1 bag: the `sensor_msgs/Image` messages of one topic. Bags of RealSense's recorder say
/// their unit.
class RosbagSource final : public RosSource {
 public:
  /// Throws an Error that names the file where it is not a bag that can be read, and as RosSource does.
  explicit RosbagSource(std::filesystem::path path, const RosbagOptions& options = {});
};

}  // namespace knuckle
