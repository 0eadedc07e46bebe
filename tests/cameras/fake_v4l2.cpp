// SPDX-License-Identifier: Apache-2.0
// A video device that is not there. Loaded before all other libraries (LD_PRELOAD), this one answers what a
// program asks of the devices that the file $KNUCKLE_FAKE_V4L2 describes; all else goes to the system. The
// memory that frames lie in is a real file in memory, so mmap needs no help.
//
// The file has a line `KEY VALUE` per setting:
//
//   device /dev/video2        its path
//   card NAME                 what it calls itself
//   open_error 13             opening it ends with this errno; 0: not
//   start_error 16            so does starting it
//   no_capture 1              it captures no images
//   planes 1                  it captures them in several planes of memory
//   formats Z16,YUYV          letters of what it offers, the first is set
//   sizes 640x480,848x480     the same
//   rates 30,60               the same
//   fixed_rate 1              its rate cannot be chosen
//   padding 6                 bytes after each row of 16-bit numbers
//   images 1                  of 16-bit numbers in a frame
//   row_bytes 3               what it says that a row has, whatever it has
//   image_bytes 100           the same of a frame
//   buffers 1                 how many buffers it gives
//   buffer_bytes 100          how long it says that they are
//   frames PATH               file of the frames, one after another, without padding
//   interval_ms 20            from one frame to the next
//   clock monotonic           whether its times are of that clock; else "unknown"
//   lose 3,7                  numbers of frames that never come
//   damage 5                  numbers of frames that come damaged
//   end unplug                after the last frame: "unplug", or "stall"
//   back_after_ms 300         when it is there again after it was unplugged, with all frames; 0: never
//   back_sizes 64x48          its sizes from then on
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdarg>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

namespace {

using Clock = std::chrono::steady_clock;

std::vector<std::string> parts_of(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

std::uint32_t code_of(std::string letters) {
  letters.resize(4, ' ');
  return v4l2_fourcc(static_cast<unsigned char>(letters[0]), static_cast<unsigned char>(letters[1]),
                     static_cast<unsigned char>(letters[2]), static_cast<unsigned char>(letters[3]));
}

struct Size {
  std::uint32_t width;
  std::uint32_t height;
};

/// What the file says.
class Scenario {
 public:
  Scenario() {
    const char* const path = std::getenv("KNUCKLE_FAKE_V4L2");
    if (path == nullptr) return;
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
      const std::size_t blank = line.find(' ');
      if (blank != std::string::npos) settings_[line.substr(0, blank)] = line.substr(blank + 1);
    }
    std::ifstream frames(text("frames"), std::ios::binary);
    frames_.assign(std::istreambuf_iterator<char>(frames), {});
  }
  std::string text(const std::string& key, const std::string& otherwise = "") const {
    const auto found = settings_.find(key);
    return found == settings_.end() ? otherwise : found->second;
  }
  int number(const std::string& key, int otherwise = 0) const {
    return std::stoi(text(key, std::to_string(otherwise)));
  }
  bool lists(const std::string& key, int number) const {
    const std::vector<std::string> numbers = parts_of(text(key), ',');
    return std::ranges::find(numbers, std::to_string(number)) != numbers.end();
  }
  std::vector<Size> sizes(const std::string& key = "sizes") const {
    std::vector<Size> sizes;
    for (const std::string& size : parts_of(text(key, "640x480"), ',')) {
      const std::size_t cross = size.find('x');
      sizes.push_back({static_cast<std::uint32_t>(std::stoi(size)),
                       static_cast<std::uint32_t>(std::stoi(size.substr(cross + 1)))});
    }
    return sizes;
  }
  const std::string& frames() const { return frames_; }

 private:
  std::map<std::string, std::string> settings_;
  std::string frames_;
};

/// A device that is open.
struct Device {
  std::uint32_t format = 0;
  Size size{};
  std::uint32_t rate = 0;
  std::uint32_t buffers = 0;
  std::vector<std::uint32_t> queued;
  int next_frame = 0;
  bool is_started = false;
  Clock::time_point started;
};

/// All devices of the process.
class World {
 public:
  static World& get() {
    static World world;
    return world;
  }

  const Scenario scenario;
  std::mutex mutex;

  bool is_ours(const char* path) const { return scenario.text("device") == path; }
  Device* find(int descriptor) {
    const auto found = devices_.find(descriptor);
    return found == devices_.end() ? nullptr : &found->second;
  }
  void close(int descriptor) { devices_.erase(descriptor); }

  int open() {
    if (const int error = scenario.number("open_error")) return failed(error);
    if (is_unplugged_) {
      const int back_ms = scenario.number("back_after_ms");
      if (back_ms == 0 || Clock::now() < unplugged_ + std::chrono::milliseconds(back_ms))
        return failed(ENOENT);
      is_unplugged_ = false;
      is_back_ = true;
    }
    const int descriptor = ::memfd_create("fake_v4l2", MFD_CLOEXEC);
    Device device;
    device.format = code_of(parts_of(scenario.text("formats", "Z16"), ',').front());
    const bool is_another = is_back_ && !scenario.text("back_sizes").empty();
    device.size = scenario.sizes(is_another ? "back_sizes" : "sizes").front();
    device.rate = static_cast<std::uint32_t>(std::stoi(scenario.text("rates", "30")));
    devices_[descriptor] = device;
    return descriptor;
  }

  std::size_t row_bytes(const Device& device) const {
    return 2 * device.size.width + static_cast<std::size_t>(scenario.number("padding"));
  }
  std::size_t frame_rows(const Device& device) const {
    return device.size.height * static_cast<std::size_t>(scenario.number("images", 1));
  }
  std::size_t buffer_bytes(const Device& device) const { return row_bytes(device) * frame_rows(device); }
  /// Where in the file of memory a buffer lies: at the start of a page.
  std::size_t buffer_offset(const Device& device, std::uint32_t index) const {
    constexpr std::size_t kPage = 4096;
    return (buffer_bytes(device) + kPage - 1) / kPage * kPage * index;
  }
  int frame_count(const Device& device) const {
    return static_cast<int>(scenario.frames().size() / (2 * device.size.width * frame_rows(device)));
  }
  bool has_ended(const Device& device) const { return device.next_frame >= frame_count(device); }
  Clock::time_point due(const Device& device) const {
    return device.started +
           std::chrono::milliseconds(scenario.number("interval_ms", 20)) * (device.next_frame + 1);
  }
  void skip_lost(Device& device) const {
    while (!has_ended(device) && scenario.lists("lose", device.next_frame)) ++device.next_frame;
  }
  /// Whether the device is gone by now.
  bool is_gone(const Device& device) {
    if (!device.is_started || !has_ended(device) || scenario.text("end") != "unplug") return false;
    if (!is_unplugged_) unplugged_ = Clock::now();
    is_unplugged_ = true;
    return true;
  }
  static int failed(int error) {
    errno = error;
    return -1;
  }

 private:
  std::map<int, Device> devices_;
  bool is_unplugged_ = false;
  bool is_back_ = false;
  Clock::time_point unplugged_;
};

int list_entry(World& world, v4l2_fmtdesc& entry) {
  const std::vector<std::string> formats = parts_of(world.scenario.text("formats", "Z16"), ',');
  if (entry.index >= formats.size()) return World::failed(EINVAL);
  entry.pixelformat = code_of(formats[entry.index]);
  return 0;
}

int list_entry(World& world, v4l2_frmsizeenum& entry) {
  const std::vector<Size> sizes = world.scenario.sizes();
  if (entry.index >= sizes.size()) return World::failed(EINVAL);
  entry.type = V4L2_FRMSIZE_TYPE_DISCRETE;
  entry.discrete = {sizes[entry.index].width, sizes[entry.index].height};
  return 0;
}

int list_entry(World& world, v4l2_frmivalenum& entry) {
  const std::vector<std::string> rates = parts_of(world.scenario.text("rates", "30"), ',');
  if (entry.index >= rates.size()) return World::failed(EINVAL);
  entry.type = V4L2_FRMIVAL_TYPE_DISCRETE;
  entry.discrete = {1, static_cast<std::uint32_t>(std::stoi(rates[entry.index]))};
  return 0;
}

void tell_format(const World& world, const Device& device, v4l2_format& format) {
  v4l2_pix_format& pixels = format.fmt.pix;
  pixels.width = device.size.width;
  pixels.height = device.size.height;
  pixels.pixelformat = device.format;
  const auto said = [&](const char* key, std::size_t bytes) {
    return static_cast<std::uint32_t>(world.scenario.number(key, static_cast<int>(bytes)));
  };
  pixels.bytesperline = said("row_bytes", world.row_bytes(device));
  pixels.sizeimage = said("image_bytes", world.buffer_bytes(device));
}

/// As drivers do it: what is not offered becomes something that is.
void set_format(const World& world, Device& device, v4l2_format& format) {
  for (const std::string& letters : parts_of(world.scenario.text("formats", "Z16"), ',')) {
    if (code_of(letters) == format.fmt.pix.pixelformat) device.format = code_of(letters);
  }
  for (const Size& size : world.scenario.sizes()) {
    if (size.width == format.fmt.pix.width && size.height == format.fmt.pix.height) device.size = size;
  }
  tell_format(world, device, format);
}

void set_rate(const World& world, Device& device, v4l2_streamparm& setting) {
  const v4l2_fract& interval = setting.parm.capture.timeperframe;
  for (const std::string& rate : parts_of(world.scenario.text("rates", "30"), ',')) {
    const auto offered = static_cast<std::uint32_t>(std::stoi(rate));
    if (interval.numerator * offered == interval.denominator) device.rate = offered;
  }
}

int give_frame(World& world, int descriptor, Device& device, v4l2_buffer& buffer) {
  if (world.is_gone(device)) return World::failed(ENODEV);
  world.skip_lost(device);
  if (world.has_ended(device) || device.queued.empty() || Clock::now() < world.due(device))
    return World::failed(EAGAIN);
  const std::uint32_t index = device.queued.front();
  device.queued.erase(device.queued.begin());
  const std::size_t row = 2 * device.size.width;
  const char* pixels = world.scenario.frames().data() + row * world.frame_rows(device) * device.next_frame;
  std::size_t place = world.buffer_offset(device, index);
  for (std::size_t i = 0; i < world.frame_rows(device); ++i) {
    if (::pwrite(descriptor, pixels, row, static_cast<off_t>(place)) < 0) return -1;
    pixels += row;
    place += world.row_bytes(device);
  }
  buffer.index = index;
  buffer.bytesused = static_cast<std::uint32_t>(world.buffer_bytes(device));
  buffer.sequence = static_cast<std::uint32_t>(device.next_frame);
  buffer.flags =
      world.scenario.text("clock", "monotonic") == "monotonic" ? V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC : 0;
  if (world.scenario.lists("damage", device.next_frame)) buffer.flags |= V4L2_BUF_FLAG_ERROR;
  const auto taken_us =
      std::chrono::duration_cast<std::chrono::microseconds>(world.due(device).time_since_epoch()).count();
  buffer.timestamp = {taken_us / 1000000, taken_us % 1000000};
  ++device.next_frame;
  return 0;
}

void tell_capability(const World& world, v4l2_capability& capability) {
  const std::string card = world.scenario.text("card", "Fake depth camera");
  std::memcpy(capability.card, card.c_str(), std::min(card.size() + 1, sizeof capability.card));
  capability.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING | V4L2_CAP_DEVICE_CAPS;
  capability.device_caps =
      V4L2_CAP_STREAMING | (world.scenario.number("no_capture") ? 0 : V4L2_CAP_VIDEO_CAPTURE);
  if (world.scenario.number("planes"))
    capability.device_caps = V4L2_CAP_STREAMING | V4L2_CAP_VIDEO_CAPTURE_MPLANE;
}

void tell_rate(const World& world, const Device& device, v4l2_captureparm& capture) {
  capture.capability = world.scenario.number("fixed_rate") ? 0 : V4L2_CAP_TIMEPERFRAME;
  capture.timeperframe = {1, device.rate};
}

int make_buffers(const World& world, int descriptor, Device& device, v4l2_requestbuffers& wanted) {
  if (const int error = world.scenario.number("start_error")) return World::failed(error);
  wanted.count = static_cast<std::uint32_t>(world.scenario.number("buffers", static_cast<int>(wanted.count)));
  device.buffers = wanted.count;
  return ::ftruncate(descriptor, static_cast<off_t>(world.buffer_offset(device, device.buffers)));
}

void tell_buffer(const World& world, const Device& device, v4l2_buffer& buffer) {
  buffer.length = static_cast<std::uint32_t>(
      world.scenario.number("buffer_bytes", static_cast<int>(world.buffer_bytes(device))));
  buffer.m.offset = static_cast<std::uint32_t>(world.buffer_offset(device, buffer.index));
}

int answer(World& world, int descriptor, Device& device, unsigned long request, void* argument) {
  if (world.is_gone(device)) return World::failed(ENODEV);
  switch (request) {
    case VIDIOC_QUERYCAP:
      tell_capability(world, *static_cast<v4l2_capability*>(argument));
      return 0;
    case VIDIOC_ENUM_FMT:
      return list_entry(world, *static_cast<v4l2_fmtdesc*>(argument));
    case VIDIOC_ENUM_FRAMESIZES:
      return list_entry(world, *static_cast<v4l2_frmsizeenum*>(argument));
    case VIDIOC_ENUM_FRAMEINTERVALS:
      return list_entry(world, *static_cast<v4l2_frmivalenum*>(argument));
    case VIDIOC_G_FMT:
      tell_format(world, device, *static_cast<v4l2_format*>(argument));
      return 0;
    case VIDIOC_S_FMT:
      set_format(world, device, *static_cast<v4l2_format*>(argument));
      return 0;
    case VIDIOC_S_PARM:
      set_rate(world, device, *static_cast<v4l2_streamparm*>(argument));
      [[fallthrough]];
    case VIDIOC_G_PARM:
      tell_rate(world, device, static_cast<v4l2_streamparm*>(argument)->parm.capture);
      return 0;
    case VIDIOC_REQBUFS:
      return make_buffers(world, descriptor, device, *static_cast<v4l2_requestbuffers*>(argument));
    case VIDIOC_QUERYBUF:
      tell_buffer(world, device, *static_cast<v4l2_buffer*>(argument));
      return 0;
    case VIDIOC_QBUF:
      device.queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return give_frame(world, descriptor, device, *static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      device.is_started = true;
      device.started = Clock::now();
      return 0;
    case VIDIOC_STREAMOFF:
      device.is_started = false;
      return 0;
    default:
      return World::failed(ENOTTY);
  }
}

/// The system's own function of that name.
template <class Function>
Function next_of(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

int open_path(const char* name, const char* path, int flags, mode_t mode) {
  World& world = World::get();
  if (world.is_ours(path)) {
    const std::lock_guard lock(world.mutex);
    return world.open();
  }
  return next_of<int (*)(const char*, int, ...)>(name)(path, flags, mode);
}

}  // namespace

// The names are the system's.
extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_path("open", path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0;
  va_end(rest);
  return open_path("open64", path, flags, mode);
}

int access(const char* path, int mode) noexcept {
  if (World::get().is_ours(path)) return 0;
  return next_of<int (*)(const char*, int)>("access")(path, mode);
}

int close(int descriptor) {
  World& world = World::get();
  {
    const std::lock_guard lock(world.mutex);
    world.close(descriptor);
  }
  return next_of<int (*)(int)>("close")(descriptor);
}

int ioctl(int descriptor, unsigned long request, ...) noexcept {
  va_list rest;
  va_start(rest, request);
  void* const argument = va_arg(rest, void*);
  va_end(rest);
  World& world = World::get();
  {
    const std::lock_guard lock(world.mutex);
    if (Device* const device = world.find(descriptor))
      return answer(world, descriptor, *device, request, argument);
  }
  return next_of<int (*)(int, unsigned long, ...)>("ioctl")(descriptor, request, argument);
}

int poll(pollfd* waiting, nfds_t count, int timeout_ms) {
  World& world = World::get();
  const auto end = Clock::now() + std::chrono::milliseconds(timeout_ms);
  while (true) {
    {
      const std::lock_guard lock(world.mutex);
      Device* const device = count == 1 ? world.find(waiting->fd) : nullptr;
      if (device == nullptr) break;
      world.skip_lost(*device);
      waiting->revents = world.is_gone(*device) ? POLLERR | POLLHUP : 0;
      const bool is_ready =
          !world.has_ended(*device) && !device->queued.empty() && Clock::now() >= world.due(*device);
      if (is_ready) waiting->revents = POLLIN;
      if (waiting->revents != 0) return 1;
    }
    if (Clock::now() >= end) return 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return next_of<int (*)(pollfd*, nfds_t, int)>("poll")(waiting, count, timeout_ms);
}

}  // extern "C"
