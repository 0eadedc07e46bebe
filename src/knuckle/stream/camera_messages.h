// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

// What a camera's process and the program say to each other. Libraries of cameras print, crash on foreign
// files, and pull in others; so they live in a process of their own (stream/process), and everything that
// comes from it is checked. Both are built together and run on one machine: numbers are the machine's own.
namespace knuckle {

/// What a message is about.
enum class CameraMessage : std::uint32_t {
  description = 1,  ///< a PipedDescription, once before the first frame
  frame = 2,        ///< a PipedFrame and its pixels
  fault = 3,        ///< a text: why there is no frame
  listing = 4,      ///< a text: "DEVICE\nNAME", a camera that is connected
  end = 5,          ///< nothing: all is said
};

/// Before every message.
struct CameraMessageHead {
  std::uint32_t magic = 0;
  std::uint32_t kind = 0;
  std::uint64_t bytes = 0;  ///< that follow
};

/// "KNMC", what each message begins with.
inline constexpr std::uint32_t kCameraMessageMagic = 0x434D4E4B;
/// Of a text in a message [bytes].
inline constexpr std::size_t kMostMessageText = 1024;

/// What pixels count.
enum class PipedDepth : std::uint32_t {
  counts = 1,      ///< multiples of PipedDescription::unit_mm; 0 is no measurement
  kinect_raw = 2,  ///< the first Kinect's 11 bits of disparity
};

/// What a camera, or a recording, is.
struct PipedDescription {
  std::int64_t frames = -1;  ///< of a recording; -1: a camera
  double unit_mm = 1.0;
  double rate_hz = 0.0;             ///< 0: not known
  double horizontal_fov_rad = 0.0;  ///< 0: not known
  double vertical_fov_rad = 0.0;
  std::uint32_t width = 0;   ///< [px]
  std::uint32_t height = 0;  ///< [px]
  PipedDepth depth = PipedDepth::counts;
  std::uint32_t is_mirrored = 0;  ///< 1: columns count from the right
  char device[128] = {};          ///< what it calls itself
};

/// Before the pixels of a frame: width x height numbers of 16 bits.
struct PipedFrame {
  std::int64_t number = 0;  ///< of a recording from 0 on; of a camera its own count
  double time_s = 0.0;      ///< by the device's clock
};

static_assert(sizeof(CameraMessageHead) == 16 && sizeof(PipedDescription) == 184 && sizeof(PipedFrame) == 16,
              "no padding, whose bytes would be anyone's");

/// Writes down what the camera calls itself, cut off where it is too long.
void set_device(PipedDescription& description, std::string_view name);

/// Writes a message; false where nobody reads any more. `rest` follows `first`.
bool put_message(int descriptor, CameraMessage kind, std::span<const std::uint8_t> first = {},
                 std::span<const std::uint8_t> rest = {});
/// The same for a text, cut off where it is too long.
bool put_text(int descriptor, CameraMessage kind, std::string_view text);

/// Throws an Error that starts with `where` where a message cannot begin so.
void check(const CameraMessageHead& head, std::string_view where);
/// The description in a message. Throws where it is not whole, or something in it cannot be.
PipedDescription parse_description(std::span<const std::uint8_t> bytes, std::string_view where);
/// A frame that such a camera may send; its pixels are the rest of `bytes`. Throws where it is not whole.
PipedFrame parse_piped_frame(std::span<const std::uint8_t> bytes, const PipedDescription& description,
                             std::string_view where);
/// The text of a message, as it may be shown.
std::string parse_text(std::span<const std::uint8_t> bytes);

/// The memory of a struct of plain numbers.
template <class Plain>
std::span<const std::uint8_t> bytes_of(const Plain& plain) {
  return {reinterpret_cast<const std::uint8_t*>(&plain), sizeof plain};
}

}  // namespace knuckle
