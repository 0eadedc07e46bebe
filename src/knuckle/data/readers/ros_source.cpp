// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros_source.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/depth_image.h"
#include "knuckle/data/readers/folder_format.h"

namespace knuckle {
namespace {

/// What the images of a topic are like.
struct ImageKind {
  std::string encoding;  ///< empty where none of the first can be read
  std::uint32_t width = 0;
  std::uint32_t height = 0;
};

ImageKind kind_of(const RosRecording& recording, const std::string& topic) {
  constexpr std::size_t kTries = 8;
  std::vector<RecordedMessage> messages = recording.messages_of(topic);
  messages.resize(std::min(messages.size(), kTries));
  for (const RecordedMessage& message : messages) {
    try {
      const std::vector<std::uint8_t> bytes = recording.read(message);
      const RosImage image = recording.parse_image(bytes, recording.place(topic));
      return {image.encoding, image.width, image.height};
    } catch (const Error&) {  // is a fault of that frame
    }
  }
  return {};
}

bool is_named_depth(std::string_view topic) {
  return lower_case(topic).find("depth") != std::string::npos;
}

/// As in /camera/infra1/image_rect_raw, /ir/image_raw, /device_0/sensor_0/Infrared_1/image/data.
bool is_named_infrared(std::string_view topic) {
  const std::string lower = lower_case(topic);
  return lower.find("infra") != std::string::npos || lower.find("/ir/") != std::string::npos ||
         lower.find("_ir/") != std::string::npos;
}

/// Infrared images are mono16, too: what they show stands in the name alone.
bool holds_depth(const RosRecording& recording, const std::string& topic) {
  if (is_named_infrared(topic) && !is_named_depth(topic)) return false;
  const std::string encoding = kind_of(recording, topic).encoding;
  if (encoding == "mono16") return is_named_depth(topic);
  return is_depth_encoding(encoding);
}

void require_images(const RosRecording& recording, const std::string& topic) {
  const std::vector<std::string> topics = recording.image_topics();
  if (std::ranges::find(topics, topic) == topics.end()) {
    fail("{}: has no images on the topic '{}'; those with images: {}", recording.path().string(), topic,
         topics.empty() ? "none" : joined(topics));
  }
}

std::string chosen_topic(const RosRecording& recording, const std::string& chosen) {
  require_images(recording, chosen);
  const std::string encoding = kind_of(recording, chosen).encoding;
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
  if (!(unit_mm > 0.0 && unit_mm <= limits::kDepthUnitMm)) {
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
  visitor.text("infrared", infrared);
  visitor.text("camera", camera);
  visitor.real("depth_unit_mm", depth_unit_mm, open_closed(0, limits::kDepthUnitMm));
}

RosSource::RosSource(std::unique_ptr<const RosRecording> recording, const RosOptions& options)
    : recording_(std::move(recording)),
      topic_(options.topic.empty() ? only_depth_topic(*recording_)
                                   : chosen_topic(*recording_, options.topic)),
      images_(find_images(topic_)),
      camera_(find_camera(options.camera)),
      unit_mm_(unit_of(*recording_, topic_, options.depth_unit_mm)) {
  find_infrared(options.infrared);
}

std::vector<RosSource::TimedImage> RosSource::find_images(const std::string& topic) const {
  std::vector<TimedImage> images;
  for (const RecordedMessage& message : recording_->messages_of(topic)) {
    images.push_back({message, time_of(*recording_, message, recording_->place(topic))});
  }
  if (images.empty()) fail("{}: holds no image", recording_->place(topic));
  std::ranges::stable_sort(images, {}, &TimedImage::time_s);
  return images;
}

/// Whether the images of a topic are infrared ones of the depth's size.
bool RosSource::shows_as_depth(const std::string& topic) const {
  const ImageKind kind = kind_of(*recording_, topic);
  return is_infrared_encoding(kind.encoding) && kind.width == static_cast<std::uint32_t>(camera_.width) &&
         kind.height == static_cast<std::uint32_t>(camera_.height);
}

void RosSource::find_infrared(const std::string& chosen) {
  if (chosen == "none") return;
  if (!chosen.empty()) {
    require_images(*recording_, chosen);
    if (!shows_as_depth(chosen)) {
      fail("{}: has no infrared images of {}x{} pixels, as the depth has", recording_->place(chosen),
           camera_.width, camera_.height);
    }
    infrared_topic_ = chosen;
  }
  for (const std::string& topic : recording_->image_topics()) {
    const bool fits = infrared_topic_.empty() && topic != topic_ && is_named_infrared(topic);
    if (fits && shows_as_depth(topic)) infrared_topic_ = topic;
  }
  if (!infrared_topic_.empty()) infrared_ = find_images(infrared_topic_);
}

/// The infrared image that was taken with the depth image of that time.
std::optional<RecordedMessage> RosSource::infrared_at(double time_s) const {
  constexpr double kTogetherSeconds = 0.01;
  const auto after = std::ranges::lower_bound(infrared_, time_s, {}, &TimedImage::time_s);
  std::optional<RecordedMessage> nearest;
  double apart_s = kTogetherSeconds;
  const auto look_at = [&](const TimedImage& image) {
    if (std::abs(image.time_s - time_s) > apart_s) return;
    apart_s = std::abs(image.time_s - time_s);
    nearest = image.message;
  };
  if (after != infrared_.begin()) look_at(*std::prev(after));
  if (after != infrared_.end()) look_at(*after);
  return nearest;
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
  if (const auto infrared = infrared_at(image.time_s)) {
    const std::string its_place = fmt::format("{}: frame {}", recording_->place(infrared_topic_), index);
    const std::vector<std::uint8_t> its_bytes = recording_->read(*infrared);
    frame.infrared = infrared_of(recording_->parse_image(its_bytes, its_place), its_place);
    require_size(frame.infrared, camera_.width, camera_.height, its_place);
  }
  return frame;
}

}  // namespace knuckle
