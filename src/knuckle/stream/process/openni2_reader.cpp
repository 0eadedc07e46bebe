// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include <OpenNI.h>

#include "knuckle/core/error.h"
#include "knuckle/stream/process/camera_readers.h"

namespace knuckle {
namespace {

constexpr int kPatienceMs = 200;     // until the program is looked at
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
  if (status != openni::STATUS_OK) fail("{}: OpenNI2: {}", what, last_fault());
}

/// A device or file with its depth stream.
class DepthDevice {
 public:
  explicit DepthDevice(const char* uri) {
    require(openni::OpenNI::initialize(), "cannot be opened");
    require(device_.open(uri), "cannot be opened");
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

/// The rows of a frame, without what lies between them.
std::vector<std::uint8_t> pixels_of(const openni::VideoFrameRef& frame, const PipedDescription& description) {
  const std::size_t row = 2 * static_cast<std::size_t>(description.width);
  const auto stride = static_cast<std::size_t>(std::max(0, frame.getStrideInBytes()));
  const bool is_of_its_size = frame.getWidth() == static_cast<int>(description.width) &&
                              frame.getHeight() == static_cast<int>(description.height) && stride >= row &&
                              static_cast<std::size_t>(std::max(0, frame.getDataSize())) >=
                                  stride * (description.height - 1) + row;
  if (!is_of_its_size) fail("a frame is not {} x {} pixels", description.width, description.height);
  const auto* from = static_cast<const std::uint8_t*>(frame.getData());
  std::vector<std::uint8_t> pixels;
  pixels.reserve(row * description.height);
  for (std::uint32_t i = 0; i < description.height; ++i, from += stride) pixels.insert(pixels.end(), from, from + row);
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
  fail("does not offer {}x{}{}; it offers {}", width, height, rate_hz > 0 ? fmt::format(" at {}", rate_hz) : "",
       offered.empty() ? "nothing" : offered);
}

void require_depth(const openni::VideoStream& stream) {
  const int format = stream.getVideoMode().getPixelFormat();
  if (!is_depth(stream.getVideoMode())) fail("sends another format than depth ({})", format);
}

/// Answers what the program asks for, frame by frame.
class OniReader {
 public:
  explicit OniReader(const std::string& path) : depth_(path.c_str()) {
    if (!depth_.device().isFile()) fail("is not an .oni recording");
    openni::PlaybackControl* const playback = depth_.device().getPlaybackControl();
    if (playback == nullptr) fail("cannot be played");
    require_depth(depth_.stream());
    require(playback->setSpeed(-1.0f), "cannot be played");  // as fast as it is read
    playback->setRepeatEnabled(false);
    description_ = depth_.description();
    description_.frames = playback->getNumberOfFrames(depth_.stream());
    require(depth_.stream().start(), "cannot be played");
  }
  const PipedDescription& description() const { return description_; }

  void answer(const Program& program, std::int64_t number) {
    if (number != next_) {
      openni::PlaybackControl& playback = *depth_.device().getPlaybackControl();
      require(playback.seek(depth_.stream(), static_cast<int>(number) + 1), "cannot be found");
    }
    next_ = number + 1;
    // What was read ahead before the seek comes first.
    for (int tries = 0; tries < 8; ++tries) {
      if (!depth_.wait(kFrameOfFileMs)) break;
      const openni::VideoFrameRef frame = depth_.take();
      if (frame.getFrameIndex() != number + 1) continue;
      program.send({number, seconds_of(frame)}, pixels_of(frame, description_));
      return;
    }
    fail("OpenNI2 does not give it; is the file cut short or damaged?");
  }

 private:
  DepthDevice depth_;
  PipedDescription description_;
  std::int64_t next_ = 0;
};

}  // namespace

void list_openni2(const Program& program) {
  require(openni::OpenNI::initialize(), "cannot be asked");
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  for (int i = 0; i < devices.getSize(); ++i)
    program.send_listing(devices[i].getUri(), fmt::format("{} {}", devices[i].getVendor(), devices[i].getName()));
}

void read_openni2(const Program& program, const std::string& uri, int width, int height, int rate_hz) {
  DepthDevice depth(uri.empty() ? nullptr : uri.c_str());
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
  OniReader reader(path);
  program.send(reader.description());
  while (const auto number = program.next_question()) reader.answer(program, *number);
}

}  // namespace knuckle
