// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <vector>

#include <libfreenect.h>

#include "knuckle/core/error.h"
#include "knuckle/stream/process/camera_readers.h"

namespace knuckle {
namespace {

constexpr double kTicksPerSecond = 60e6;

/// libfreenect, until the end of its life.
class FreenectContext {
 public:
  FreenectContext() {
    if (::freenect_init(&context_, nullptr) < 0) fail("libfreenect cannot use USB");
    ::freenect_set_log_level(context_, FREENECT_LOG_FATAL);
    ::freenect_select_subdevices(context_, FREENECT_DEVICE_CAMERA);
  }
  ~FreenectContext() { ::freenect_shutdown(context_); }
  FreenectContext(const FreenectContext&) = delete;
  FreenectContext& operator=(const FreenectContext&) = delete;
  freenect_context* get() const { return context_; }

 private:
  freenect_context* context_ = nullptr;
};

/// A Kinect that sends depth.
class Kinect {
 public:
  Kinect(const Program& program, int index, freenect_depth_format format) : program_(program) {
    const int count = ::freenect_num_devices(context_.get());
    if (count <= index) {
      fail("there is no such Kinect, {} are connected; is it plugged in, with its own power?",
           std::max(0, count));
    }
    if (::freenect_open_device(context_.get(), &device_, index) < 0) {
      fail(
          "cannot be opened: another program may use it, or this user may not (docs/cameras.md says how to "
          "allow it)");
    }
    ::freenect_set_user(device_, this);
    ::freenect_set_depth_callback(device_, take);
    mode_ = ::freenect_find_depth_mode(FREENECT_RESOLUTION_MEDIUM, format);
    if (mode_.is_valid == 0 || ::freenect_set_depth_mode(device_, mode_) < 0)
      fail("cannot be set to this format of depth");
  }
  ~Kinect() {
    if (device_ == nullptr) return;
    ::freenect_stop_depth(device_);
    ::freenect_close_device(device_);
  }
  Kinect(const Kinect&) = delete;
  Kinect& operator=(const Kinect&) = delete;

  const freenect_frame_mode& mode() const { return mode_; }
  void run() {
    if (::freenect_start_depth(device_) < 0) fail("cannot be started");
    while (!program_.is_gone()) {
      timeval longest{0, 100000};
      if (::freenect_process_events_timeout(context_.get(), &longest) < 0) fail("the Kinect was unplugged");
    }
  }

 private:
  static void take(freenect_device* device, void* pixels, std::uint32_t ticks) {
    static_cast<Kinect*>(::freenect_get_user(device))->send(pixels, ticks);
  }
  void send(const void* pixels, std::uint32_t ticks) {
    // 32 bits of ticks start again at 0 after 71 s.
    if (last_ticks_) elapsed_ticks_ += ticks - *last_ticks_;
    last_ticks_ = ticks;
    const PipedFrame frame{number_++, static_cast<double>(elapsed_ticks_) / kTicksPerSecond};
    const auto bytes = static_cast<std::size_t>(2) * mode_.width * mode_.height;
    program_.send(frame, {static_cast<const std::uint8_t*>(pixels), bytes});
  }

  const Program& program_;
  FreenectContext context_;
  freenect_device* device_ = nullptr;
  freenect_frame_mode mode_{};
  std::optional<std::uint32_t> last_ticks_;
  std::uint64_t elapsed_ticks_ = 0;
  std::int64_t number_ = 0;
};

}  // namespace

void list_freenect(const Program& program) {
  const FreenectContext context;
  const int count = ::freenect_num_devices(context.get());
  for (int index = 0; index < count; ++index) program.send_listing(std::to_string(index), "Kinect");
}

void read_freenect(const Program& program, int index, bool in_millimetres) {
  Kinect kinect(program, index, in_millimetres ? FREENECT_DEPTH_MM : FREENECT_DEPTH_11BIT);
  PipedDescription description;
  description.width = static_cast<std::uint32_t>(kinect.mode().width);
  description.height = static_cast<std::uint32_t>(kinect.mode().height);
  description.rate_hz = kinect.mode().framerate;
  description.depth = in_millimetres ? PipedDepth::counts : PipedDepth::kinect_raw;
  set_device(description, "Kinect");
  program.send(description);
  kinect.run();
}

}  // namespace knuckle
