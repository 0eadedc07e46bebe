// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/v4l2_device.h"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

std::string advice(int error) {
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return "the camera is not there; is it plugged in? `knuckle cameras` lists those that are";
    case EACCES:
    case EPERM:
      return "this user may not use it; add the user to the group video (sudo usermod -aG video $USER) and "
             "log "
             "in again";
    case EBUSY:
      return "another program uses it; end that one (`fuser -v /dev/video*` names it)";
    default:
      return std::generic_category().message(error);
  }
}

}  // namespace

bool is_gone(int error) {
  return error == ENODEV || error == ENXIO || error == EIO || error == ESHUTDOWN;
}

std::string v4l2_fault(std::string_view name, std::string_view what, int error) {
  return fmt::format("{}: {}: {}", name, what, advice(error));
}

V4l2Device::V4l2Device(std::string path) : path_(std::move(path)), name_("v4l2:" + path_) {
  descriptor_ = ::open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ < 0) throw Error(v4l2_fault(name_, "cannot be opened", errno));
  try {
    require_capture();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

V4l2Device::~V4l2Device() {
  ::close(descriptor_);
}

int V4l2Device::control(unsigned long code, void* argument) const {
  int result = -1;
  do result = ::ioctl(descriptor_, code, argument);
  while (result < 0 && errno == EINTR);
  return result < 0 ? errno : 0;
}

void V4l2Device::require_capture() {
  v4l2_capability capability{};
  if (const int error = try_request(VIDIOC_QUERYCAP, capability)) {
    if (error == ENOTTY || error == EINVAL) fail("{}: is not a video device", name_);
    fail_with(error, "cannot be asked what it is");
  }
  const auto* const card = reinterpret_cast<const char*>(capability.card);
  card_.assign(card, std::find(card, card + sizeof capability.card, '\0'));
  const bool is_per_node = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  const auto can = is_per_node ? capability.device_caps : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) != 0 && (can & V4L2_CAP_STREAMING) != 0) return;
  if ((can & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0) {
    fail("{}: captures images in several planes of memory, which Knuckle does not read", name_);
  }
  fail("{}: does not capture images; `knuckle cameras` lists the devices that do", name_);
}

void V4l2Device::fail_with(int error, std::string_view what) const {
  if (is_gone(error)) throw DeviceLost(fmt::format("{}: the camera was unplugged", name_));
  throw Error(v4l2_fault(name_, what, error));
}

bool V4l2Device::wait(std::chrono::milliseconds longest) const {
  pollfd waiting{descriptor_, POLLIN, 0};
  const int count = ::poll(&waiting, 1, static_cast<int>(longest.count()));
  if (count < 0 && errno != EINTR) fail_with(errno, "cannot be waited for");
  if (count <= 0) return false;
  if ((waiting.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0 && (waiting.revents & POLLIN) == 0) {
    fail_with(ENODEV, "cannot be waited for");
  }
  return true;
}

}  // namespace knuckle
