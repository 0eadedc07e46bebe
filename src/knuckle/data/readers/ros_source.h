// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/ros_recording.h"

namespace knuckle {

/// Settings of a source of ROS topics.
struct RosOptions {
  std::string topic = {};      ///< of the depth images; empty: the only one there is
  std::string infrared = {};   ///< of the infrared images; empty: the first that fits; "none"
  std::string camera = {};     ///< file with a [camera] table; empty: the topic's camera info
  double depth_unit_mm = 0.0;  ///< millimetres per count, (0, 1000]; 0: what the recording says, else 1

  void visit(OptionVisitor& visitor);
};

/// Depth of a recording of ROS: the images of one topic, as counts (16UC1, mono16) or metres (32FC1), in the
/// order of their stamps; where a driver gives no stamps, in that of recording. The camera is the first
/// camera info beside the topic. Infrared images are those of the topic that `infrared` names, or of the
/// first one that is named so and has images of the same size (of a RealSense camera the left one, through
/// which depth is seen); a frame has the one that is nearest in time, where it was taken within 10 ms.
///
/// Opening reads the stamp of each image, for which packed chunks are unpacked once. An image that is damaged
/// is a fault of its frame.
class RosSource : public FrameSource {
 public:
  /// Throws an Error that names the file where it has no depth topic, several and none is chosen (and lists
  /// them), or no camera.
  RosSource(std::unique_ptr<const RosRecording> recording, const RosOptions& options);

  std::int64_t size() const final { return static_cast<std::int64_t>(images_.size()); }
  Frame read(std::int64_t index) const final;
  FrameLabel read_label(std::int64_t index) const final;
  std::optional<Convention> convention() const final { return std::nullopt; }

 private:
  struct TimedImage {
    RecordedMessage message;
    double time_s = 0.0;
  };

  std::vector<TimedImage> find_images(const std::string& topic) const;
  void find_infrared(const std::string& chosen);
  bool shows_as_depth(const std::string& topic) const;
  std::optional<RecordedMessage> infrared_at(double time_s) const;
  Camera find_camera(const std::string& file) const;

  std::unique_ptr<const RosRecording> recording_;
  std::string topic_;
  std::vector<TimedImage> images_;  ///< by time
  Camera camera_;
  double unit_mm_;
  std::string infrared_topic_;        ///< empty: there is none
  std::vector<TimedImage> infrared_;  ///< by time
};

}  // namespace knuckle
