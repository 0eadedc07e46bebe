// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "knuckle/data/readers/ros_source.h"

namespace knuckle {

/// Settings of an `mcap:` source.
using McapOptions = RosOptions;

/// Depth of a recording of ROS 2 in an MCAP file: the `sensor_msgs/msg/Image` messages of one topic.
class McapSource final : public RosSource {
 public:
  /// Throws an Error that names the file where it is not an MCAP file that can be read, and as RosSource
  /// does.
  explicit McapSource(std::filesystem::path path, const McapOptions& options = {});
};

}  // namespace knuckle
