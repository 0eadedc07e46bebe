// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/camera_messages.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <numbers>

#include <unistd.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"

namespace knuckle {
namespace {

bool write_all(int descriptor, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

bool is_between(double value, double low, double high) {
  return value >= low && value <= high;  // so not NaN
}

std::uint64_t pixel_bytes(const PipedDescription& description) {
  return std::uint64_t{2} * description.width * description.height;
}

bool is_possible(const PipedDescription& description) {
  const auto is_side = [](std::uint32_t side) { return side >= 1 && side <= limits::kImageSide; };
  constexpr double kHighestRate = 10000.0;
  return is_side(description.width) && is_side(description.height) &&
         pixel_bytes(description) + sizeof(PipedFrame) <= limits::kCameraMessageBytes &&
         description.frames >= -1 && description.frames <= limits::kFrames && description.unit_mm > 0.0 &&
         is_between(description.unit_mm, 0.0, limits::kDepthUnitMm) &&
         is_between(description.rate_hz, 0.0, kHighestRate) &&
         is_between(description.horizontal_fov_rad, 0.0, std::numbers::pi) &&
         is_between(description.vertical_fov_rad, 0.0, std::numbers::pi) &&
         (description.depth == PipedDepth::counts || description.depth == PipedDepth::kinect_raw) &&
         description.is_mirrored <= 1;
}

template <class Plain>
Plain plain_from(std::span<const std::uint8_t> bytes) {
  Plain plain;
  std::memcpy(&plain, bytes.data(), sizeof plain);
  return plain;
}

}  // namespace

void set_device(PipedDescription& description, std::string_view name) {
  constexpr std::size_t kMost = sizeof description.device - 1;
  const std::string_view part = name.substr(0, kMost);
  std::ranges::fill(description.device, '\0');
  std::ranges::copy(part, description.device);
}

bool put_message(int descriptor, CameraMessage kind, std::span<const std::uint8_t> first,
                 std::span<const std::uint8_t> rest) {
  const CameraMessageHead head{kCameraMessageMagic, static_cast<std::uint32_t>(kind),
                               first.size() + rest.size()};
  return write_all(descriptor, bytes_of(head)) && write_all(descriptor, first) && write_all(descriptor, rest);
}

bool put_text(int descriptor, CameraMessage kind, std::string_view text) {
  const std::string_view part = text.substr(0, kMostMessageText);
  return put_message(descriptor, kind, {reinterpret_cast<const std::uint8_t*>(part.data()), part.size()});
}

void check(const CameraMessageHead& head, std::string_view where) {
  const bool is_known = head.kind >= static_cast<std::uint32_t>(CameraMessage::description) &&
                        head.kind <= static_cast<std::uint32_t>(CameraMessage::end);
  if (head.magic != kCameraMessageMagic || !is_known || head.bytes > limits::kCameraMessageBytes) {
    fail("{}: the process that reads it sent something that is no message", where);
  }
}

PipedDescription parse_description(std::span<const std::uint8_t> bytes, std::string_view where) {
  if (bytes.size() != sizeof(PipedDescription)) fail("{}: its description is not whole", where);
  auto description = plain_from<PipedDescription>(bytes);
  description.device[sizeof description.device - 1] = '\0';
  if (!is_possible(description)) {
    fail("{}: cannot be depth: {} x {} pixels of {} mm, {} frames, fields of view {} x {}", where,
         description.width, description.height, description.unit_mm, description.frames,
         description.horizontal_fov_rad, description.vertical_fov_rad);
  }
  return description;
}

PipedFrame parse_piped_frame(std::span<const std::uint8_t> bytes, const PipedDescription& description,
                             std::string_view where) {
  if (bytes.size() != sizeof(PipedFrame) + pixel_bytes(description)) fail("{}: a frame is not whole", where);
  const auto frame = plain_from<PipedFrame>(bytes);
  if (!std::isfinite(frame.time_s)) fail("{}: a frame has the time {}", where, frame.time_s);
  return frame;
}

std::string parse_text(std::span<const std::uint8_t> bytes) {
  const auto part = bytes.first(std::min(bytes.size(), kMostMessageText));
  return {part.begin(), part.end()};
}

}  // namespace knuckle
