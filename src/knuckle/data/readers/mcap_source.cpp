// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/mcap_source.h"

#include <utility>

#include "knuckle/data/readers/mcap.h"
#include "knuckle/data/readers/ros2_messages.h"

namespace knuckle {
namespace {

constexpr const char* kImageType = "sensor_msgs/msg/Image";
constexpr const char* kCameraInfoType = "sensor_msgs/msg/CameraInfo";

/// An MCAP file with its messages as ROS 2 serialises them.
class McapRecording final : public RosRecording {
 public:
  explicit McapRecording(std::filesystem::path path)
      : mcap_(std::move(path), {kImageType, kCameraInfoType}) {}

  const std::filesystem::path& path() const override { return mcap_.path(); }
  std::vector<std::string> image_topics() const override { return mcap_.topics_of(kImageType); }
  std::vector<RecordedMessage> messages_of(std::string_view topic) const override {
    return mcap_.messages_of(topic);
  }
  Bytes read(const RecordedMessage& message, std::uint64_t most_bytes) const override {
    return mcap_.read(message, most_bytes);
  }
  double parse_stamp(std::span<const std::uint8_t> message, std::string_view where) const override {
    return parse_ros2_stamp(message, where);
  }
  RosImage parse_image(std::span<const std::uint8_t> message, std::string_view where) const override {
    return parse_ros2_image(message, where);
  }
  RosCameraInfo parse_camera_info(std::span<const std::uint8_t> message,
                                  std::string_view where) const override {
    return parse_ros2_camera_info(message, where);
  }

 private:
  Mcap mcap_;
};

}  // namespace

McapSource::McapSource(std::filesystem::path path, const McapOptions& options)
    : RosSource(std::make_unique<McapRecording>(std::move(path)), options) {}

}  // namespace knuckle
