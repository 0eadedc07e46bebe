// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/rosbag_source.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/text.h"
#include "knuckle/data/readers/ros1_messages.h"
#include "knuckle/data/readers/rosbag.h"

namespace knuckle {
namespace {

/// A bag with its messages as ROS 1 serialises them.
class RosbagRecording final : public RosRecording {
 public:
  explicit RosbagRecording(std::filesystem::path path) : bag_(std::move(path)) {}

  const std::filesystem::path& path() const override { return bag_.path(); }
  std::vector<std::string> image_topics() const override { return topics_of("sensor_msgs/Image"); }
  std::vector<RecordedMessage> messages_of(std::string_view topic) const override {
    return bag_.messages_of(topic);
  }
  Bytes read(const RecordedMessage& message, std::uint64_t most_bytes) const override {
    return bag_.read(message, most_bytes);
  }
  std::optional<double> unit_mm(std::string_view image_topic) const override;
  double parse_stamp(std::span<const std::uint8_t> message, std::string_view where) const override {
    return parse_ros1_stamp(message, where);
  }
  RosImage parse_image(std::span<const std::uint8_t> message, std::string_view where) const override {
    return parse_ros1_image(message, where);
  }
  RosCameraInfo parse_camera_info(std::span<const std::uint8_t> message,
                                  std::string_view where) const override {
    return parse_ros1_camera_info(message, where);
  }

 private:
  std::vector<std::string> topics_of(std::string_view type) const;
  std::string unit_topic_of(std::string_view image_topic) const;

  Rosbag bag_;
};

std::vector<std::string> RosbagRecording::topics_of(std::string_view type) const {
  std::vector<std::string> topics;
  for (const BagConnection& connection : bag_.connections()) {
    if (connection.type == type) topics.push_back(connection.topic);
  }
  std::ranges::sort(topics);
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return topics;
}

/// Where RealSense's recorder writes the metres per count of a topic "/device_0/sensor_0/Depth_0/image/data".
std::string RosbagRecording::unit_topic_of(std::string_view image_topic) const {
  const std::size_t device = image_topic.find('/', 1);
  const std::size_t sensor = device == std::string_view::npos ? device : image_topic.find('/', device + 1);
  if (!image_topic.starts_with("/device_") || sensor == std::string_view::npos) return "";
  const std::string prefix = std::string(image_topic.substr(0, sensor)) + "/option/";
  for (const std::string& topic : topics_of("std_msgs/Float32")) {
    if (!topic.starts_with(prefix)) continue;
    std::string name = lower_case(std::string_view(topic).substr(prefix.size()));
    std::ranges::replace(name, ' ', '_');
    if (name == "depth_units/value") return topic;
  }
  return "";
}

std::optional<double> RosbagRecording::unit_mm(std::string_view image_topic) const {
  const std::string topic = unit_topic_of(image_topic);
  const std::vector<RecordedMessage> messages = bag_.messages_of(topic);
  if (topic.empty() || messages.empty()) return std::nullopt;
  const float metres = parse_ros1_float(bag_.read(messages.front()), place(topic));
  // Through the shortest text: a float's 0.001 is meant to be 1 mm.
  return 1000.0 * parse_number(fmt::format("{}", metres), place(topic));
}

}  // namespace

RosbagSource::RosbagSource(std::filesystem::path path, const RosbagOptions& options)
    : RosSource(std::make_unique<RosbagRecording>(std::move(path)), options) {}

}  // namespace knuckle
