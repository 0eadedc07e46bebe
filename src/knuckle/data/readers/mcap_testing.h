// SPDX-License-Identifier: Apache-2.0
// Writes MCAP recordings of ROS 2 for tests.
#pragma once

#include <bit>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "knuckle/data/readers/recording_testing.h"
#include "knuckle/storage/deflate.h"

namespace knuckle::testing {

/// Writes a message in CDR, of either order of bytes.
class CdrWriter {
 public:
  explicit CdrWriter(bool is_big_endian) : is_big_endian_(is_big_endian) {
    bytes_ = std::string{'\0', is_big_endian ? '\0' : '\1', '\0', '\0'};
  }

  template <class T>
  CdrWriter& number(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\x77';
    std::string written = little(value);
    if (is_big_endian_) std::ranges::reverse(written);
    bytes_ += written;
    return *this;
  }
  CdrWriter& real(double value) { return number(std::bit_cast<std::uint64_t>(value)); }
  CdrWriter& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_ += value + '\0';
    return *this;
  }
  CdrWriter& list(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes_ += value;
    return *this;
  }
  CdrWriter& header(double stamp_s) {
    const double whole = std::floor(stamp_s);
    number(static_cast<std::uint32_t>(static_cast<std::int32_t>(whole)));
    number(static_cast<std::uint32_t>(std::llround((stamp_s - whole) * 1e9)));
    return text("camera_frame");
  }
  const std::string& bytes() const { return bytes_; }

 private:
  bool is_big_endian_;
  std::string bytes_;
};

inline std::string image_of(const TestImage& image, int first, bool is_big_endian_cdr = false) {
  return CdrWriter(is_big_endian_cdr)
      .header(image.stamp_s)
      .number(image.height)
      .number(image.width)
      .text(image.encoding)
      .number(static_cast<std::uint8_t>(image.is_big_endian))
      .number(image.step())
      .list(testing::pixels_of(image, first))
      .bytes();
}

inline std::string camera_info_of(const TestCameraInfo& info, bool is_big_endian_cdr = false) {
  CdrWriter writer(is_big_endian_cdr);
  writer.header(1.0).number(info.height).number(info.width).text(info.model);
  writer.number(static_cast<std::uint32_t>(info.d.size()));
  for (const double value : info.d) writer.real(value);
  for (const double value : info.k) writer.real(value);
  for (const double value : {1, 0, 0, 0, 1, 0, 0, 0, 1}) writer.real(value);
  for (const double value : info.p) writer.real(value);
  for (int i = 0; i < 6; ++i) writer.number(std::uint32_t{0});  // binning, region of interest
  return writer.number(std::uint8_t{0}).bytes();
}

inline std::string mcap_record(int kind, const std::string& content) {
  return std::string(1, static_cast<char>(kind)) + little(static_cast<std::uint64_t>(content.size())) +
         content;
}

inline std::uint32_t sum_of(const std::string& bytes) {
  return crc32({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
}

/// How an MCAP file is laid out, and what is wrong with it.
struct McapTestForm {
  std::string compression = "";  ///< of chunks, as the file says it
  bool has_chunks = true;
  bool has_indexes = true;  ///< of messages, after each chunk
  bool has_summary = true;
  bool repeats_channels = true;  ///< in the summary
  bool has_sums = true;
  bool is_closed = true;
  std::string magic = "\x89MCAP0\r\n";
  std::string encoding = "cdr";
  std::uint64_t more_chunk_bytes = 0;   ///< that a chunk says it has
  std::uint64_t more_packed_bytes = 0;  ///< the same of its packed ones
  std::uint64_t more_messages = 0;      ///< that the statistics say a channel has
  std::uint64_t offset_of_offsets = 0;  ///< by which the index is wrong
  int index_of_channel = 0;             ///< that an index names in place of the right one
};

/// Writes MCAP files by the format's description, with faults where a test wants them.
class McapTestWriter : private McapTestForm {
 public:
  explicit McapTestWriter(McapTestForm form = {}) : McapTestForm(std::move(form)) {}

  void add(const std::string& topic, const std::string& type, double recorded_s, const std::string& message) {
    const std::uint16_t channel = channel_of(topic, type);
    const auto time = static_cast<std::uint64_t>(std::llround(recorded_s * 1e9));
    entries_[channel].push_back(little(time) +
                                little(static_cast<std::uint64_t>(part_.size()) + offset_of_offsets));
    part_ +=
        mcap_record(5, little(channel) + little(std::uint32_t{1}) + little(time) + little(time) + message);
    ++counts_[channel];
    if (!has_chunks) end_chunk();
  }

  void end_chunk() {
    if (!has_chunks) {
      body_ += std::exchange(part_, "");
      return;
    }
    const std::uint32_t sum = has_sums ? sum_of(part_) : 0;
    const std::string bytes = testing::packed(part_, compression);
    body_ += mcap_record(6, little(std::uint64_t{0}) + little(std::uint64_t{9}) +
                                little(static_cast<std::uint64_t>(part_.size()) + more_chunk_bytes) +
                                little(sum) + with_length(compression) +
                                little(static_cast<std::uint64_t>(bytes.size()) + more_packed_bytes) + bytes);
    for (const auto& [channel, entries] : entries_) {
      std::string all;
      for (const std::string& entry : entries) all += entry;
      const auto named = static_cast<std::uint16_t>(index_of_channel != 0 ? index_of_channel : channel);
      if (has_indexes) body_ += mcap_record(7, little(named) + with_length(all));
    }
    entries_.clear();
    part_.clear();
    ++chunk_count_;
  }

  std::string bytes() {
    if (!part_.empty()) end_chunk();
    const std::string data = magic + mcap_record(1, with_length("ros2") + with_length("test")) + body_;
    std::string file = data + mcap_record(15, little(has_sums ? sum_of(data) : 0));
    const std::size_t summary_at = file.size();
    if (has_summary) file += (repeats_channels ? definitions_ : "") + statistics();
    std::string footer =
        little(static_cast<std::uint64_t>(has_summary ? summary_at : 0)) + little(std::uint64_t{0});
    footer = '\2' + little(std::uint64_t{20}) + footer;
    const std::uint32_t sum = sum_of(file.substr(summary_at) + footer);
    if (is_closed) file += footer + little(has_summary && has_sums ? sum : 0) + magic;
    return file;
  }

 private:
  std::uint16_t channel_of(const std::string& topic, const std::string& type) {
    const auto known = channels_.find(topic);
    if (known != channels_.end()) return known->second;
    const auto number = static_cast<std::uint16_t>(channels_.size() + 7);
    channels_[topic] = number;
    const std::string definition =
        mcap_record(3, little(number) + with_length(type) + with_length("ros2msg") + with_length("# text")) +
        mcap_record(4, little(number) + little(number) + with_length(topic) + with_length(encoding) +
                           with_length(with_length("offered_qos_profiles") + with_length("")));
    part_ += definition;
    definitions_ += definition;
    return number;
  }

  std::string statistics() const {
    std::string counts;
    for (const auto& [channel, count] : counts_) counts += little(channel) + little(count + more_messages);
    return mcap_record(11, std::string(8 + 2 + 4 + 4 + 4, '\0') + little(chunk_count_) +
                               std::string(8 + 8, '\0') + with_length(counts));
  }

  std::string body_;
  std::string part_;  ///< the chunk that is being written
  std::string definitions_;
  std::map<std::string, std::uint16_t> channels_;
  std::map<std::uint16_t, std::vector<std::string>> entries_;
  std::map<std::uint16_t, std::uint64_t> counts_;
  std::uint32_t chunk_count_ = 0;
};

inline constexpr const char* kMcapDepth = "/camera/depth/image_raw";
inline constexpr const char* kMcapInfo = "/camera/depth/camera_info";
inline constexpr const char* kMcapColour = "/camera/color/image_raw";
inline constexpr const char* kMcapImage = "sensor_msgs/msg/Image";
inline constexpr const char* kMcapCameraInfo = "sensor_msgs/msg/CameraInfo";

/// `count` frames, 30 per second, 3 a chunk, with a camera, colour images and another topic between.
inline McapTestWriter filled(const McapTestForm& form, int count = 8) {
  McapTestWriter mcap(form);
  for (int i = 0; i < count; ++i) {
    const double time_s = 1000.0 + i / 30.0;
    mcap.add(kMcapInfo, kMcapCameraInfo, time_s, camera_info_of({}));
    mcap.add(kMcapDepth, kMcapImage, time_s + 0.5, image_of({.stamp_s = time_s}, 500 + i));
    mcap.add(kMcapColour, kMcapImage, time_s, image_of({.encoding = "rgb8"}, 0));
    mcap.add("/tf", "tf2_msgs/msg/TFMessage", time_s, "anything");
    if (i % 3 == 2) mcap.end_chunk();
  }
  return mcap;
}

/// One depth image beside its camera.
inline McapTestWriter with_image(const std::string& image, const TestCameraInfo& info = {}) {
  McapTestWriter mcap;
  mcap.add(kMcapInfo, kMcapCameraInfo, 0.0, camera_info_of(info));
  mcap.add(kMcapDepth, kMcapImage, 1.0, image);
  return mcap;
}

}  // namespace knuckle::testing
