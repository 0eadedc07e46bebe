// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include <OpenNI.h>

#include "knuckle/core/error.h"
#include "knuckle/stream/process/camera_readers.h"

namespace knuckle {
namespace {

constexpr int kPatienceMs = 200;      // until the program is looked at
constexpr int kFrameOfFileMs = 5000;  // a file is read as fast as it can be

/// What OpenNI2 says of its last fault, in one line.
std::string last_fault() {
  std::string text = openni::OpenNI::getExtendedError();
  std::ranges::replace(text, '\n', ' ');
  text.erase(0, text.find_first_not_of(" \t"));
  text.erase(text.find_last_not_of(" \t") + 1);
  return text.empty() ? "it does not say why" : text;
}

void require(openni::Status status, std::string_view what) {
  if (status != openni::STATUS_OK) fail("{} (OpenNI2: {})", what, last_fault());
}

/// A device or file with its depth stream.
class DepthDevice {
 public:
  /// `fault` is what to say where it cannot be opened.
  DepthDevice(const char* uri, std::string_view fault) {
    require(openni::OpenNI::initialize(), fault);
    require(device_.open(uri), fault);
    if (!device_.hasSensor(openni::SENSOR_DEPTH)) fail("has no depth");
    require(stream_.create(device_, openni::SENSOR_DEPTH), "its depth cannot be read");
  }

  openni::Device& device() { return device_; }
  openni::VideoStream& stream() { return stream_; }

  PipedDescription description() const {
    const openni::VideoMode mode = stream_.getVideoMode();
    PipedDescription description;
    description.width = static_cast<std::uint32_t>(std::max(0, mode.getResolutionX()));
    description.height = static_cast<std::uint32_t>(std::max(0, mode.getResolutionY()));
    description.rate_hz = std::max(0, mode.getFps());
    description.unit_mm = mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM ? 0.1 : 1.0;
    description.horizontal_fov_rad = stream_.getHorizontalFieldOfView();
    description.vertical_fov_rad = stream_.getVerticalFieldOfView();
    description.is_mirrored = stream_.getMirroringEnabled() ? 1 : 0;
    set_device(description, device_.getDeviceInfo().getName());
    return description;
  }

  /// Whether a frame came within that time.
  bool wait(int longest_ms) {
    openni::VideoStream* streams[] = {&stream_};
    int ready = -1;
    const openni::Status status = openni::OpenNI::waitForAnyStream(streams, 1, &ready, longest_ms);
    if (status == openni::STATUS_TIME_OUT) return false;
    require(status, "the camera is lost");
    return true;
  }

  openni::VideoFrameRef take() {
    openni::VideoFrameRef frame;
    require(stream_.readFrame(&frame), "a frame cannot be read");
    return frame;
  }

 private:
  openni::Device device_;
  openni::VideoStream stream_;
};

/// Whether a frame has all pixels that it should have.
bool has_size_of(const openni::VideoFrameRef& frame, const PipedDescription& description) {
  const std::size_t row = 2 * static_cast<std::size_t>(description.width);
  const auto stride = static_cast<std::size_t>(std::max(0, frame.getStrideInBytes()));
  const auto bytes = static_cast<std::size_t>(std::max(0, frame.getDataSize()));
  return frame.getWidth() == static_cast<int>(description.width) &&
         frame.getHeight() == static_cast<int>(description.height) && stride >= row &&
         bytes >= stride * (description.height - 1) + row;
}

/// The rows of a frame, without what lies between them.
std::vector<std::uint8_t> pixels_of(const openni::VideoFrameRef& frame, const PipedDescription& description) {
  if (!has_size_of(frame, description))
    fail("a frame is not {} x {} pixels", description.width, description.height);
  const std::size_t row = 2 * static_cast<std::size_t>(description.width);
  const auto stride = static_cast<std::size_t>(frame.getStrideInBytes());
  const auto* from = static_cast<const std::uint8_t*>(frame.getData());
  std::vector<std::uint8_t> pixels;
  pixels.reserve(row * description.height);
  for (std::uint32_t i = 0; i < description.height; ++i, from += stride)
    pixels.insert(pixels.end(), from, from + row);
  return pixels;
}

double seconds_of(const openni::VideoFrameRef& frame) {
  return 1e-6 * static_cast<double>(frame.getTimestamp());
}

bool is_depth(const openni::VideoMode& mode) {
  return mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_1_MM ||
         mode.getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM;
}

/// Sets the first mode that is as asked for; 0 is anything.
void set_mode(openni::VideoStream& stream, int width, int height, int rate_hz) {
  if (width == 0 && height == 0 && rate_hz == 0) return;
  const openni::VideoMode now = stream.getVideoMode();
  if (width == 0) width = now.getResolutionX();
  if (height == 0) height = now.getResolutionY();
  const auto& modes = stream.getSensorInfo().getSupportedVideoModes();
  std::string offered;
  for (int i = 0; i < modes.getSize(); ++i) {
    const openni::VideoMode& mode = modes[i];
    if (!is_depth(mode)) continue;
    const bool is_rate = rate_hz == 0 || mode.getFps() == rate_hz;
    if (mode.getResolutionX() == width && mode.getResolutionY() == height && is_rate) {
      require(stream.setVideoMode(mode), "cannot be set to this size and rate");
      return;
    }
    offered += fmt::format("{}{}x{} at {}", offered.empty() ? "" : ", ", mode.getResolutionX(),
                           mode.getResolutionY(), mode.getFps());
  }
  fail("does not offer {}x{}{}; it offers {}", width, height,
       rate_hz > 0 ? fmt::format(" at {}", rate_hz) : "", offered.empty() ? "nothing" : offered);
}

void require_depth(const openni::VideoStream& stream) {
  const int format = stream.getVideoMode().getPixelFormat();
  if (!is_depth(stream.getVideoMode())) fail("sends another format than depth ({})", format);
}

/// Sends all frames of a recording. OpenNI2 can also go to a frame, and crashes as it does (2.2.0.33).
void send_recording(const Program& program, DepthDevice& depth, const PipedDescription& description) {
  std::int64_t number = -1;
  while (number + 1 < description.frames) {
    if (!depth.wait(kFrameOfFileMs))
      fail("OpenNI2 gives no more frames after the first {}; is the file cut short or damaged?", number + 1);
    const openni::VideoFrameRef frame = depth.take();
    number = frame.getFrameIndex() - 1;
    if (!has_size_of(frame, description)) continue;  // who reads its neighbours sees that it is missing
    program.send({number, seconds_of(frame)}, pixels_of(frame, description));
  }
}

}  // namespace

void list_openni2(const Program& program) {
  require(openni::OpenNI::initialize(), "cannot be asked");
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  for (int i = 0; i < devices.getSize(); ++i) {
    program.send_listing(devices[i].getUri(),
                         fmt::format("{} {}", devices[i].getVendor(), devices[i].getName()));
  }
}

void read_openni2(const Program& program, const std::string& uri, int width, int height, int rate_hz) {
  DepthDevice depth(uri.empty() ? nullptr : uri.c_str(),
                    "cannot be opened; is it plugged in, and may this user use it (docs/cameras.md)?");
  if (depth.device().isFile()) fail("is a file; read it as oni:FILE");
  set_mode(depth.stream(), width, height, rate_hz);
  require_depth(depth.stream());
  depth.stream().setMirroringEnabled(false);  // where it cannot be, the description says so
  require(depth.stream().start(), "cannot be started");
  const PipedDescription description = depth.description();
  program.send(description);
  while (!program.is_gone()) {
    if (!depth.wait(kPatienceMs)) continue;
    const openni::VideoFrameRef frame = depth.take();
    program.send({frame.getFrameIndex(), seconds_of(frame)}, pixels_of(frame, description));
  }
}

void read_oni(const Program& program, const std::string& path) {
  DepthDevice depth(path.c_str(), "cannot be opened; is it an .oni recording, and whole?");
  openni::PlaybackControl* const playback = depth.device().getPlaybackControl();
  if (!depth.device().isFile() || playback == nullptr) fail("is not an .oni recording");
  require_depth(depth.stream());
  require(playback->setSpeed(-1.0f), "cannot be played");  // as fast as it is read
  playback->setRepeatEnabled(false);
  PipedDescription description = depth.description();
  description.frames = playback->getNumberOfFrames(depth.stream());
  program.send(description);
  require(depth.stream().start(), "cannot be played");
  send_recording(program, depth, description);
  program.send_end();
}

}  // namespace knuckle
