// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros_source.h"

#include <algorithm>
#include <utility>

#include "knuckle/core/text.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/folder_format.h"

namespace knuckle {
namespace {

constexpr double kHighestUnitMm = 1000.0;

/// Of the images of a topic; empty where none of the first can be read.
std::string encoding_of(const RosRecording& recording, const std::string& topic) {
  constexpr std::size_t kTries = 8;
  std::vector<RecordedMessage> messages = recording.messages_of(topic);
  messages.resize(std::min(messages.size(), kTries));
  for (const RecordedMessage& message : messages) {
    try {
      const std::vector<std::uint8_t> bytes = recording.read(message);
      return recording.parse_image(bytes, recording.place(topic)).encoding;
    } catch (const Error&) {  // is a fault of that frame
    }
  }
  return "";
}

bool is_named_depth(std::string_view topic) {
  std::string lower(topic);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower.find("depth") != std::string::npos;
}

/// Infrared images are mono16, too: what they show stands in the name alone.
bool holds_depth(const RosRecording& recording, const std::string& topic) {
  const std::string encoding = encoding_of(recording, topic);
  if (encoding == "mono16") return is_named_depth(topic);
  return is_depth_encoding(encoding);
}

std::string chosen_topic(const RosRecording& recording, const std::string& chosen) {
  const std::vector<std::string> topics = recording.image_topics();
  if (std::ranges::find(topics, chosen) == topics.end()) {
    fail("{}: has no images on the topic '{}'; those with images: {}", recording.path().string(), chosen,
         topics.empty() ? "none" : joined(topics));
  }
  const std::string encoding = encoding_of(recording, chosen);
  if (!encoding.empty() && !is_depth_encoding(encoding)) {
    fail("{}: has images of encoding '{:.40}', expected depth: 16UC1, mono16 or 32FC1",
         recording.place(chosen), printable(encoding));
  }
  return chosen;
}

std::string only_depth_topic(const RosRecording& recording) {
  const std::vector<std::string> topics = recording.image_topics();
  std::vector<std::string> with_depth;
  for (const std::string& topic : topics) {
    if (holds_depth(recording, topic)) with_depth.push_back(topic);
  }
  if (with_depth.size() == 1) return with_depth.front();
  const std::string name = recording.path().string();
  if (with_depth.empty()) {
    fail("{}: has no depth topic (sensor_msgs/Image of 16UC1, mono16 or 32FC1); topics with images: {}", name,
         topics.empty() ? "none" : joined(topics));
  }
  fail("{}: has {} depth topics, choose one by ?topic=: {}", name, with_depth.size(), joined(with_depth));
}

/// When an image was taken [s].
double time_of(const RosRecording& recording, const RecordedMessage& message, std::string_view where) {
  try {
    const double stamp_s = recording.parse_stamp(recording.read(message, RosRecording::kStampBytes), where);
    return stamp_s > 0.0 ? stamp_s : message.recorded_s;
  } catch (const Error&) {  // whoever reads the frame is told
    return message.recorded_s;
  }
}

double unit_of(const RosRecording& recording, const std::string& topic, double chosen) {
  if (chosen > 0.0) return chosen;
  const double unit_mm = recording.unit_mm(topic).value_or(1.0);
  if (!(unit_mm > 0.0 && unit_mm <= kHighestUnitMm)) {
    fail("{}: says {} m per count, expected a number from 0 to 1; give it by ?depth_unit_mm=",
         recording.place(topic), unit_mm / 1000);
  }
  return unit_mm;
}

}  // namespace

std::string RosRecording::place(std::string_view topic) const {
  return fmt::format("{}: topic {}", path().string(), topic);
}

void RosOptions::visit(OptionVisitor& visitor) {
  visitor.text("topic", topic);
  visitor.text("camera", camera);
  visitor.real("depth_unit_mm", depth_unit_mm, open_closed(0, kHighestUnitMm));
}

RosSource::RosSource(std::unique_ptr<const RosRecording> recording, const RosOptions& options)
    : recording_(std::move(recording)),
      topic_(options.topic.empty() ? only_depth_topic(*recording_)
                                   : chosen_topic(*recording_, options.topic)),
      images_(find_images()),
      camera_(find_camera(options.camera)),
      unit_mm_(unit_of(*recording_, topic_, options.depth_unit_mm)) {}

std::vector<RosSource::TimedImage> RosSource::find_images() const {
  std::vector<TimedImage> images;
  for (const RecordedMessage& message : recording_->messages_of(topic_)) {
    images.push_back({message, time_of(*recording_, message, recording_->place(topic_))});
  }
  if (images.empty()) fail("{}: holds no image", recording_->place(topic_));
  std::ranges::stable_sort(images, {}, &TimedImage::time_s);
  return images;
}

Camera RosSource::find_camera(const std::string& file) const {
  if (!file.empty()) return read_camera_file(file);
  const std::string topic = camera_topic_of(topic_);
  const std::vector<RecordedMessage> messages = recording_->messages_of(topic);
  if (messages.empty()) {
    fail("{}: has no camera on the topic '{}'; give it by ?camera=FILE.toml", recording_->path().string(),
         topic);
  }
  const std::vector<std::uint8_t> bytes = recording_->read(messages.front());
  return camera_of(recording_->parse_camera_info(bytes, recording_->place(topic)), topic_,
                   recording_->place(topic));
}

FrameLabel RosSource::read_label(std::int64_t index) const {
  const TimedImage& image = images_.at(static_cast<std::size_t>(index));
  return {camera_, std::nullopt, image.time_s, 0, fmt::format("{:06}", index), std::nullopt};
}

Frame RosSource::read(std::int64_t index) const {
  const TimedImage& image = images_.at(static_cast<std::size_t>(index));
  const std::string where = fmt::format("{}: frame {}", recording_->place(topic_), index);
  const std::vector<std::uint8_t> bytes = recording_->read(image.message);
  Frame frame;
  frame.name = fmt::format("{:06}", index);
  frame.camera = camera_;
  frame.depth_mm = depth_mm_of(recording_->parse_image(bytes, where), unit_mm_, where);
  require_size(frame.depth_mm, camera_.width, camera_.height, where);
  frame.time_s = image.time_s;
  return frame;
}

}  // namespace knuckle
