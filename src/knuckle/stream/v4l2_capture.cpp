// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/v4l2_capture.h"

#include <cerrno>
#include <utility>

#include <linux/videodev2.h>
#include <sys/mman.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr std::uint32_t kBuffers = 4;  // the device fills one while others wait
constexpr std::uint32_t kLeastBuffers = 2;
constexpr std::uint32_t kMostBuffers = 64;
constexpr std::string_view kStarting = "cannot be started";
constexpr std::string_view kReading = "cannot be read";

v4l2_buffer buffer_numbered(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

std::optional<double> monotonic_time(const v4l2_buffer& buffer) {
  constexpr double kMicrosecond = 1e-6;
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return std::nullopt;
  return static_cast<double>(buffer.timestamp.tv_sec) +
         kMicrosecond * static_cast<double>(buffer.timestamp.tv_usec);
}

}  // namespace

MappedBuffer::MappedBuffer(const V4l2Device& device, std::size_t bytes, std::uint32_t offset) {
  void* const start = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, device.descriptor(), offset);
  if (start == MAP_FAILED) device.fail_with(errno, kStarting);
  bytes_ = {static_cast<std::uint8_t*>(start), bytes};
}

MappedBuffer::~MappedBuffer() {
  if (!bytes_.empty()) ::munmap(bytes_.data(), bytes_.size());
}

MappedBuffer::MappedBuffer(MappedBuffer&& other) noexcept : bytes_(std::exchange(other.bytes_, {})) {}

V4l2Capture::V4l2Capture(const std::string& path, const V4l2Options& options)
    : device_(path),
      mode_(set_mode(device_, options)),
      depth_unit_mm_(options.depth_unit_mm > 0.0 ? options.depth_unit_mm
                                                 : mode_.layout.format.depth_unit_mm) {
  map_buffers();
  for (std::uint32_t index = 0; index < buffers_.size(); ++index) queue(index);
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  device_.request(VIDIOC_STREAMON, type, kStarting);
}

V4l2Capture::~V4l2Capture() {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  device_.try_request(VIDIOC_STREAMOFF, type);
}

void V4l2Capture::map_buffers() {
  v4l2_requestbuffers wanted{};
  wanted.count = kBuffers;
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  wanted.memory = V4L2_MEMORY_MMAP;
  device_.request(VIDIOC_REQBUFS, wanted, kStarting);
  if (wanted.count < kLeastBuffers || wanted.count > kMostBuffers) {
    fail("{}: gives {} buffers, expected {} to {}", device_.name(), wanted.count, kLeastBuffers,
         kMostBuffers);
  }
  for (std::uint32_t index = 0; index < wanted.count; ++index) {
    v4l2_buffer buffer = buffer_numbered(index);
    device_.request(VIDIOC_QUERYBUF, buffer, kStarting);
    if (buffer.length < mode_.layout.frame_bytes()) {
      fail("{}: gives buffers of {} bytes for frames of {}", device_.name(), buffer.length,
           mode_.layout.frame_bytes());
    }
    buffers_.emplace_back(device_, buffer.length, buffer.m.offset);
  }
}

void V4l2Capture::queue(std::uint32_t index) const {
  v4l2_buffer buffer = buffer_numbered(index);
  const int error = device_.try_request(VIDIOC_QBUF, buffer);
  // One that is gone by now has still given its last frame; whoever waits for the next is told.
  if (error != 0 && !is_gone(error)) device_.fail_with(error, kReading);
}

std::optional<V4l2Frame> V4l2Capture::next(std::chrono::milliseconds longest) {
  if (!device_.wait(longest)) return std::nullopt;
  v4l2_buffer buffer = buffer_numbered(0);
  if (const int error = device_.try_request(VIDIOC_DQBUF, buffer)) {
    if (error == EAGAIN) return std::nullopt;
    device_.fail_with(error, kReading);
  }
  if (buffer.index >= buffers_.size()) fail("{}: gives a buffer that there is not", device_.name());
  const bool is_whole =
      (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && buffer.bytesused >= mode_.layout.frame_bytes();
  std::optional<V4l2Frame> frame;
  if (is_whole) {
    const auto bytes = buffers_[buffer.index].bytes();
    frame = {decode_v4l2(bytes, mode_.layout, depth_unit_mm_), buffer.sequence, monotonic_time(buffer)};
  }
  queue(buffer.index);
  return frame;
}

}  // namespace knuckle
