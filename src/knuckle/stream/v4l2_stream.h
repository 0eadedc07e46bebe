// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/stream/camera_stream.h"
#include "knuckle/stream/stream_clock.h"
#include "knuckle/stream/v4l2_capture.h"

namespace knuckle {

/// A camera that Linux knows as a video device with depth (Z16, INZI, Y16): RealSense and others, without a
/// library of their makers. Where it is lost and `wait_s` is above 0, the stream waits for it to come back,
/// and goes on in a new sequence.
class V4l2Stream final : public CameraStream {
 public:
  /// Opens and starts the camera, which may take `wait_s` to be there. Throws as V4l2Capture does, and where
  /// its intrinsics are not known and that is refused.
  V4l2Stream(std::string path, const V4l2Options& options,
             UnknownIntrinsics unknown = UnknownIntrinsics::refuse);

  std::optional<Frame> next() override;
  std::int64_t lost_frames() const override { return lost_; }
  const CameraFacts& facts() const override { return facts_; }

 private:
  using Clock = std::chrono::steady_clock;
  V4l2Frame wait_for_frame();
  /// Opens the camera again and again until that works, for `wait_s` at most; then throws why it does not.
  void open();
  void reopen();
  Frame frame_of(V4l2Frame taken);
  void count_lost(std::uint32_t number);

  std::string path_;
  V4l2Options options_;
  UnknownIntrinsics unknown_;
  std::optional<V4l2Capture> capture_;  ///< nothing: the stream has ended
  Camera camera_;
  CameraFacts facts_;
  StreamClock clock_;
  std::optional<std::uint32_t> last_number_;
  std::int64_t frames_ = 0;
  std::int64_t lost_ = 0;
  int sequence_ = 0;
};

/// What there is of video devices that capture images, /dev/video0 to /dev/video255.
struct V4l2Listing {
  std::string path;
  std::string card;                  ///< may hold any bytes
  std::vector<std::string> formats;  ///< that are or may be depth, as in "Z16"
  std::string fault;                 ///< why it cannot be asked; empty where it can
};

/// All that are there, also those without depth and those that may not be opened.
std::vector<V4l2Listing> list_v4l2();

}  // namespace knuckle
