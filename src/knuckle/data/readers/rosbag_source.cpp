// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/rosbag_source.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/text.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/ros1_messages.h"

namespace knuckle {
namespace {

constexpr std::string_view kImageType = "sensor_msgs/Image";
constexpr double kHighestUnitMm = 1000.0;

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

/// The topics of a type, each once.
std::vector<std::string> topics_of(const Rosbag& bag, std::string_view type) {
  std::vector<std::string> topics;
  for (const BagConnection& connection : bag.connections()) {
    if (connection.type == type) topics.push_back(connection.topic);
  }
  std::ranges::sort(topics);
  topics.erase(std::unique(topics.begin(), topics.end()), topics.end());
  return topics;
}

/// Of the images of a topic; empty where none of the first can be read.
std::string encoding_of(const Rosbag& bag, const std::string& topic) {
  constexpr std::size_t kTries = 8;
  std::vector<BagMessage> messages = bag.messages_of(topic);
  messages.resize(std::min(messages.size(), kTries));
  for (const BagMessage& message : messages) {
    try {
      const std::vector<std::uint8_t> bytes = bag.read(message);
      return parse_ros1_image(bytes, bag.place(topic)).encoding;
    } catch (const Error&) {  // is a fault of that frame
    }
  }
  return "";
}

/// Infrared images are mono16, too: what they show stands in the name alone.
bool holds_depth(const Rosbag& bag, const std::string& topic) {
  const std::string encoding = encoding_of(bag, topic);
  if (encoding == "mono16") return lower(topic).find("depth") != std::string::npos;
  return is_depth_encoding(encoding);
}

std::string chosen_topic(const Rosbag& bag, const std::string& chosen) {
  const std::vector<std::string> topics = topics_of(bag, kImageType);
  if (std::ranges::find(topics, chosen) == topics.end()) {
    fail("{}: has no images on the topic '{}'; those with images: {}", bag.path().string(), chosen,
         topics.empty() ? "none" : joined(topics));
  }
  const std::string encoding = encoding_of(bag, chosen);
  if (!encoding.empty() && !is_depth_encoding(encoding)) {
    fail("{}: has images of encoding '{:.40}', expected depth: 16UC1, mono16 or 32FC1", bag.place(chosen),
         printable(encoding));
  }
  return chosen;
}

std::string only_depth_topic(const Rosbag& bag) {
  const std::vector<std::string> topics = topics_of(bag, kImageType);
  std::vector<std::string> with_depth;
  for (const std::string& topic : topics) {
    if (holds_depth(bag, topic)) with_depth.push_back(topic);
  }
  if (with_depth.size() == 1) return with_depth.front();
  const std::string name = bag.path().string();
  if (with_depth.empty()) {
    fail("{}: has no depth topic (sensor_msgs/Image of 16UC1, mono16 or 32FC1); topics with images: {}", name,
         topics.empty() ? "none" : joined(topics));
  }
  fail("{}: has {} depth topics, choose one by ?topic=: {}", name, with_depth.size(), joined(with_depth));
}

/// When an image was taken [s].
double time_of(const Rosbag& bag, const BagMessage& message, std::string_view where) {
  try {
    const double stamp_s = parse_ros1_stamp(bag.read(message, kRos1StampBytes), where);
    return stamp_s > 0.0 ? stamp_s : message.recorded_s;
  } catch (const Error&) {  // whoever reads the frame is told
    return message.recorded_s;
  }
}

/// Where RealSense's recorder writes the metres per count of a topic "/device_0/sensor_0/Depth_0/image/data".
std::string unit_topic_of(const Rosbag& bag, std::string_view image_topic) {
  const std::size_t device = image_topic.find('/', 1);
  const std::size_t sensor = device == std::string_view::npos ? device : image_topic.find('/', device + 1);
  if (!image_topic.starts_with("/device_") || sensor == std::string_view::npos) return "";
  const std::string prefix = std::string(image_topic.substr(0, sensor)) + "/option/";
  for (const std::string& topic : topics_of(bag, "std_msgs/Float32")) {
    if (!topic.starts_with(prefix)) continue;
    std::string name = lower(std::string_view(topic).substr(prefix.size()));
    std::ranges::replace(name, ' ', '_');
    if (name == "depth_units/value") return topic;
  }
  return "";
}

}  // namespace

void RosbagOptions::visit(OptionVisitor& visitor) {
  visitor.text("topic", topic);
  visitor.text("camera", camera);
  visitor.real("depth_unit_mm", depth_unit_mm, open_closed(0, kHighestUnitMm));
}

RosbagSource::RosbagSource(std::filesystem::path path, const RosbagOptions& options)
    : bag_(std::move(path)),
      topic_(options.topic.empty() ? only_depth_topic(bag_) : chosen_topic(bag_, options.topic)),
      images_(find_images()),
      camera_(find_camera(options.camera)),
      unit_mm_(find_unit_mm(options.depth_unit_mm)) {}

std::vector<RosbagSource::TimedImage> RosbagSource::find_images() const {
  std::vector<TimedImage> images;
  for (const BagMessage& message : bag_.messages_of(topic_)) {
    images.push_back({message, time_of(bag_, message, bag_.place(topic_))});
  }
  if (images.empty()) fail("{}: holds no image", bag_.place(topic_));
  std::ranges::stable_sort(images, {}, &TimedImage::time_s);
  return images;
}

Camera RosbagSource::find_camera(const std::string& file) const {
  if (!file.empty()) return read_camera_file(file);
  const std::string topic = camera_topic_of(topic_);
  const std::vector<BagMessage> messages = bag_.messages_of(topic);
  if (messages.empty())
    fail("{}: has no camera on the topic '{}'; give it by ?camera=FILE.toml", bag_.path().string(), topic);
  const std::vector<std::uint8_t> bytes = bag_.read(messages.front());
  return camera_of(parse_ros1_camera_info(bytes, bag_.place(topic)), topic_, bag_.place(topic));
}

double RosbagSource::find_unit_mm(double chosen) const {
  if (chosen > 0.0) return chosen;
  const std::string topic = unit_topic_of(bag_, topic_);
  const std::vector<BagMessage> messages = bag_.messages_of(topic);
  if (topic.empty() || messages.empty()) return 1.0;
  const float metres = parse_ros1_float(bag_.read(messages.front()), bag_.place(topic));
  // Through the shortest text: a float's 0.001 is meant to be 1 mm.
  const double unit_mm = 1000.0 * parse_number(fmt::format("{}", metres), bag_.place(topic));
  if (!(unit_mm > 0.0 && unit_mm <= kHighestUnitMm)) {
    fail("{}: says {} m per count, expected a number from 0 to 1; give it by ?depth_unit_mm=",
         bag_.place(topic), metres);
  }
  return unit_mm;
}

FrameLabel RosbagSource::read_label(std::int64_t index) const {
  const TimedImage& image = images_.at(static_cast<std::size_t>(index));
  return {camera_, std::nullopt, image.time_s, 0, fmt::format("{:06}", index), std::nullopt};
}

Frame RosbagSource::read(std::int64_t index) const {
  const TimedImage& image = images_.at(static_cast<std::size_t>(index));
  const std::string where = fmt::format("{}: frame {}", bag_.place(topic_), index);
  const std::vector<std::uint8_t> bytes = bag_.read(image.message);
  Frame frame;
  frame.name = fmt::format("{:06}", index);
  frame.camera = camera_;
  frame.depth_mm = depth_mm_of(parse_ros1_image(bytes, where), unit_mm_, where);
  require_size(frame.depth_mm, camera_.width, camera_.height, where);
  frame.time_s = image.time_s;
  return frame;
}

}  // namespace knuckle
