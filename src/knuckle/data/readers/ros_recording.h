// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/data/readers/ros_camera.h"
#include "knuckle/data/readers/ros_image.h"

namespace knuckle {

/// Where a message of a recording is.
struct RecordedMessage {
  std::uint32_t connection = 0;  ///< that wrote it, by the recording's own number
  std::uint32_t chunk = 0;       ///< which of the recording's
  std::uint64_t offset = 0;      ///< in the unpacked chunk [bytes]
  double recorded_s = 0.0;       ///< when it was recorded [s]
};

/// A recording of ROS topics, of any format. Safe to be read by many threads.
class RosRecording {
 public:
  using Bytes = std::vector<std::uint8_t>;

  virtual ~RosRecording() = default;

  virtual const std::filesystem::path& path() const = 0;
  /// The topics with messages of the type Image, each once, sorted.
  virtual std::vector<std::string> image_topics() const = 0;
  /// All messages of a topic of images or their cameras, in the order of the file; none where there is no
  /// such topic.
  virtual std::vector<RecordedMessage> messages_of(std::string_view topic) const = 0;
  /// The content of a message, or its first bytes where it has more than `most_bytes`.
  virtual Bytes read(const RecordedMessage& message, std::uint64_t most_bytes = ~std::uint64_t{0}) const = 0;
  /// The millimetres per count that the recording says for a topic of images; nothing where it does not.
  virtual std::optional<double> unit_mm(std::string_view /*image_topic*/) const { return std::nullopt; }

  // How messages are serialised. All throw an Error that starts with `where` where the bytes are none.

  /// The stamp of a message that begins with a Header [s], for which its first `kStampBytes` are enough.
  virtual double parse_stamp(std::span<const std::uint8_t> message, std::string_view where) const = 0;
  static constexpr std::uint64_t kStampBytes = 12;
  /// An Image; its pixels are those of `message`.
  virtual RosImage parse_image(std::span<const std::uint8_t> message, std::string_view where) const = 0;
  virtual RosCameraInfo parse_camera_info(std::span<const std::uint8_t> message,
                                          std::string_view where) const = 0;

  /// "file: topic /camera/depth/image_raw", for messages.
  std::string place(std::string_view topic) const;
};

}  // namespace knuckle
