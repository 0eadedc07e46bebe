// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/stream/camera_process.h"
#include "knuckle/stream/camera_stream.h"
#include "knuckle/stream/intrinsics.h"
#include "knuckle/stream/stream_clock.h"

namespace knuckle {

/// Settings of a `freenect:` camera.
struct FreenectOptions {
  std::string depth =
      "raw";  ///< raw: 11 bits, made millimetres by us; mm: by libfreenect, as the device was calibrated
  double timeout_s = 5.0;  ///< without a frame, then the camera is lost; [0.1, 3600]
  IntrinsicsOptions intrinsics;

  void visit(OptionVisitor& visitor);
};

/// Settings of an `openni2:` camera.
struct Openni2Options {
  int width = 0;           ///< [0, 16384] [px]; 0: that of ?camera=, else what the device is set to
  int height = 0;          ///< the same
  int rate_hz = 0;         ///< frames per second, [0, 1000]; 0: what the device is set to
  double timeout_s = 5.0;  ///< without a frame, then the camera is lost; [0.1, 3600]
  IntrinsicsOptions intrinsics;

  void visit(OptionVisitor& visitor);
};

/// The intrinsics that fields of view tell; nothing where they are not known.
std::optional<Intrinsics> intrinsics_of(const PipedDescription& description);

/// The depth of a frame as it came through the pipe: in millimetres, not mirrored. Throws an Error that
/// starts with `where` where a value cannot be.
Image<float> depth_of(const ReceivedMessage& message, const PipedDescription& description,
                      std::string_view where);

/// A camera behind a library, which runs in a process of its own.
class ProcessStream final : public CameraStream {
 public:
  /// Starts `process` and waits for its first message. `where` is what messages are about.
  ProcessStream(std::unique_ptr<CameraProcess> process, std::string where,
                const IntrinsicsOptions& intrinsics, double timeout_s, UnknownIntrinsics unknown);

  std::optional<Frame> next() override;
  std::int64_t lost_frames() const override { return lost_; }
  const CameraFacts& facts() const override { return facts_; }

 private:
  Frame wait_for_frame();

  std::unique_ptr<CameraProcess> process_;  ///< null: the stream has ended
  std::string where_;
  double timeout_s_;
  PipedDescription description_;
  Camera camera_;
  CameraFacts facts_;
  StreamClock clock_;
  std::optional<std::int64_t> last_number_;
  std::int64_t frames_ = 0;
  std::int64_t lost_ = 0;
};

/// Cameras that a library sees.
struct ProcessListing {
  std::string device;  ///< as it is opened
  std::string name;
};

/// What `knuckle-camera list KIND` tells. Throws an Error where that fails.
std::vector<ProcessListing> list_by_process(const std::string& kind);

}  // namespace knuckle
