// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/rosbag.h"

namespace knuckle {

/// Settings of a `rosbag:` source.
struct RosbagOptions {
  std::string topic = {};      ///< of the depth images; empty: the only one there is
  std::string camera = {};     ///< file with a [camera] table; empty: the topic's camera info
  double depth_unit_mm = 0.0;  ///< millimetres per count, (0, 1000]; 0: what the bag says, else 1

  void visit(OptionVisitor& visitor);
};

/// Depth of a ROS 1 bag: the `sensor_msgs/Image` messages of one topic, as counts (16UC1, mono16) or metres
/// (32FC1), in the order of their stamps; where a driver gives no stamps, in that of recording. The camera is
/// the first `sensor_msgs/CameraInfo` beside the topic. Bags of RealSense's recorder say their unit.
///
/// Opening reads the stamp of each image, for which packed chunks are unpacked once. An image that is damaged
/// is a fault of its frame.
class RosbagSource final : public FrameSource {
 public:
  /// Throws an Error that names the file where it is not a bag that can be read, has no depth topic, several
  /// and none is chosen (and lists them), or no camera.
  explicit RosbagSource(std::filesystem::path path, const RosbagOptions& options = {});

  std::int64_t size() const override { return static_cast<std::int64_t>(images_.size()); }
  Frame read(std::int64_t index) const override;
  FrameLabel read_label(std::int64_t index) const override;
  std::optional<Convention> convention() const override { return std::nullopt; }

 private:
  struct TimedImage {
    BagMessage message;
    double time_s = 0.0;
  };

  std::vector<TimedImage> find_images() const;
  Camera find_camera(const std::string& file) const;
  double find_unit_mm(double chosen) const;

  Rosbag bag_;
  std::string topic_;
  std::vector<TimedImage> images_;  ///< by time
  Camera camera_;
  double unit_mm_;
};

}  // namespace knuckle
