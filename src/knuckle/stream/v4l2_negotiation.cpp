// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/v4l2_negotiation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include <linux/videodev2.h>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/named_table.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::uint32_t kMostEntries = 256;  // of a list that a device gives
constexpr std::string_view kSettingFormat = "cannot be set to a format";

/// Goes through a list of a device until it ends.
template <class Entry>
std::vector<Entry> entries_of(const V4l2Device& device, unsigned long code, const Entry& wanted) {
  std::vector<Entry> entries;
  for (std::uint32_t index = 0; index < kMostEntries; ++index) {
    Entry entry = wanted;
    entry.index = index;
    if (device.try_request(code, entry) != 0) break;
    entries.push_back(entry);
  }
  return entries;
}

std::string joined_or(const std::vector<std::string>& parts, std::string_view otherwise) {
  return parts.empty() ? std::string(otherwise) : joined(parts);
}

std::string offered_formats_text(const V4l2Device& device) {
  std::vector<std::string> names;
  for (const std::uint32_t code : offered_formats(device)) names.push_back(printable(four_letters(code)));
  return joined_or(names, "none");
}

std::string offered_sizes_text(const V4l2Device& device, std::uint32_t code) {
  v4l2_frmsizeenum wanted{};
  wanted.pixel_format = code;
  std::vector<std::string> sizes;
  for (const v4l2_frmsizeenum& entry : entries_of(device, VIDIOC_ENUM_FRAMESIZES, wanted)) {
    const v4l2_frmsize_stepwise& steps = entry.stepwise;
    const bool is_discrete = entry.type == V4L2_FRMSIZE_TYPE_DISCRETE;
    sizes.push_back(is_discrete ? fmt::format("{}x{}", entry.discrete.width, entry.discrete.height)
                                : fmt::format("{}x{} to {}x{}", steps.min_width, steps.min_height,
                                              steps.max_width, steps.max_height));
  }
  return joined_or(sizes, "sizes that it does not list");
}

double rate_of(const v4l2_fract& interval) {
  return interval.numerator == 0 ? 0.0 : static_cast<double>(interval.denominator) / interval.numerator;
}

std::string offered_rates_text(const V4l2Device& device, const V4l2Layout& layout) {
  v4l2_frmivalenum wanted{};
  wanted.pixel_format = layout.format.code;
  wanted.width = static_cast<std::uint32_t>(layout.width);
  wanted.height = static_cast<std::uint32_t>(layout.height);
  std::vector<std::string> rates;
  for (const v4l2_frmivalenum& entry : entries_of(device, VIDIOC_ENUM_FRAMEINTERVALS, wanted)) {
    const bool is_discrete = entry.type == V4L2_FRMIVAL_TYPE_DISCRETE;
    rates.push_back(is_discrete ? fmt::format("{:.4g}", rate_of(entry.discrete))
                                : fmt::format("{:.4g} to {:.4g}", rate_of(entry.stepwise.max),
                                              rate_of(entry.stepwise.min)));
  }
  return joined_or(rates, "rates that it does not list");
}

V4l2DepthFormat chosen_format(const V4l2Device& device, const std::string& name) {
  const std::vector<V4l2DepthFormat> offered = offered_depth_formats(device);
  for (const V4l2DepthFormat& format : offered) {
    // y16 may as well be infrared: only who asks for it gets it.
    if (name == "auto" ? format.name != "y16" : format.name == name) return format;
  }
  if (name == "auto" && !offered.empty()) {
    fail(
        "{}: offers Y16, which with some cameras is depth and with others infrared, and no format that is "
        "surely depth (Z16, INZI); say ?format=y16 where it is depth",
        device.name());
  }
  fail("{}: does not offer {}; it offers {}", device.name(),
       name == "auto" ? "depth (Z16 or INZI)" : "the format " + name, offered_formats_text(device));
}

struct Size {
  int width = 0;
  int height = 0;
};

/// What is asked for; 0 x 0 where nothing is.
Size chosen_size(const V4l2Device& device, const V4l2Options& options) {
  if ((options.width == 0) != (options.height == 0)) {
    fail("{}: width and height belong together; say both or neither", device.name());
  }
  const std::optional<Camera> camera = camera_file_of(options.intrinsics);
  if (!camera) return {options.width, options.height};
  if (options.width != 0 && (options.width != camera->width || options.height != camera->height)) {
    fail("{}: {}x{} is asked for, but the camera of {} has {}x{}", device.name(), options.width,
         options.height, options.intrinsics.camera, camera->width, camera->height);
  }
  return {camera->width, camera->height};
}

v4l2_format current_format(const V4l2Device& device) {
  v4l2_format current{};
  current.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  device.request(VIDIOC_G_FMT, current, "does not say its format");
  return current;
}

void check(const V4l2Device& device, const V4l2Layout& layout, std::size_t image_bytes) {
  const bool is_sane = layout.width >= 1 && layout.width <= limits::kImageSide && layout.height >= 1 &&
                       layout.height <= limits::kImageSide &&
                       layout.line_bytes >= 2 * static_cast<std::size_t>(layout.width) &&
                       layout.line_bytes <= 8 * static_cast<std::size_t>(limits::kImageSide);
  if (!is_sane || image_bytes < layout.frame_bytes()) {
    fail("{}: says that its images are {}x{} in {} bytes ({} per row), which cannot be", device.name(),
         layout.width, layout.height, image_bytes, layout.line_bytes);
  }
}

V4l2Layout set_format(const V4l2Device& device, const V4l2DepthFormat& format, const Size& size) {
  v4l2_format setting = current_format(device);
  v4l2_pix_format& pixels = setting.fmt.pix;
  const bool has_size = size.width > 0;
  if (has_size) {
    pixels.width = static_cast<std::uint32_t>(size.width);
    pixels.height = static_cast<std::uint32_t>(size.height);
  }
  pixels.pixelformat = format.code;
  pixels.field = V4L2_FIELD_ANY;
  pixels.bytesperline = 0;
  pixels.sizeimage = 0;
  device.request(VIDIOC_S_FMT, setting, kSettingFormat);
  const bool is_size = !has_size || (static_cast<int>(pixels.width) == size.width &&
                                     static_cast<int>(pixels.height) == size.height);
  if (pixels.pixelformat != format.code || !is_size) {
    fail("{}: does not offer {} of {}x{}; it offers {}", device.name(), four_letters(format.code), size.width,
         size.height, offered_sizes_text(device, format.code));
  }
  V4l2Layout layout{format, static_cast<int>(pixels.width), static_cast<int>(pixels.height),
                    pixels.bytesperline};
  // Some drivers count both images of INZI into a row, some leave the number out.
  const auto tight = 2 * static_cast<std::size_t>(layout.width);
  if (layout.line_bytes == 0 || layout.line_bytes == tight * static_cast<std::size_t>(format.images)) {
    layout.line_bytes = tight;
  }
  check(device, layout, pixels.sizeimage);
  return layout;
}

double set_rate(const V4l2Device& device, const V4l2Layout& layout, double rate_hz) {
  v4l2_streamparm setting{};
  setting.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  const v4l2_captureparm& capture = setting.parm.capture;
  const bool has_rates =
      device.try_request(VIDIOC_G_PARM, setting) == 0 && (capture.capability & V4L2_CAP_TIMEPERFRAME) != 0;
  if (rate_hz == 0.0) return has_rates ? rate_of(capture.timeperframe) : 0.0;
  if (!has_rates) fail("{}: does not let its rate be chosen; leave ?rate= out", device.name());
  constexpr double kParts = 1000.0;
  setting.parm.capture.timeperframe = {static_cast<std::uint32_t>(kParts),
                                       static_cast<std::uint32_t>(std::lround(kParts * rate_hz))};
  device.request(VIDIOC_S_PARM, setting, "cannot be set to a rate");
  const double got_hz = rate_of(capture.timeperframe);
  constexpr double kTolerance = 0.01;  // 29.97 is 30
  if (std::abs(got_hz - rate_hz) > kTolerance * rate_hz) {
    fail("{}: does not offer {:g} frames per second at {}x{}; it offers {}", device.name(), rate_hz,
         layout.width, layout.height, offered_rates_text(device, layout));
  }
  return got_hz;
}

}  // namespace

std::vector<std::uint32_t> offered_formats(const V4l2Device& device) {
  v4l2_fmtdesc wanted{};
  wanted.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  std::vector<std::uint32_t> codes;
  for (const v4l2_fmtdesc& entry : entries_of(device, VIDIOC_ENUM_FMT, wanted))
    codes.push_back(entry.pixelformat);
  return codes;
}

std::vector<V4l2DepthFormat> offered_depth_formats(const V4l2Device& device) {
  const std::vector<std::uint32_t> codes = offered_formats(device);
  std::vector<V4l2DepthFormat> formats;
  for (const V4l2DepthFormat& format : v4l2_depth_formats()) {
    if (std::ranges::find(codes, format.code) != codes.end()) formats.push_back(format);
  }
  return formats;
}

std::string V4l2Mode::text() const {
  const std::string size =
      fmt::format("{} {}x{}", four_letters(layout.format.code), layout.width, layout.height);
  return rate_hz > 0.0 ? fmt::format("{}, {:.4g} per second", size, rate_hz) : size;
}

V4l2Mode set_mode(const V4l2Device& device, const V4l2Options& options) {
  const V4l2DepthFormat format = chosen_format(device, options.format);
  const V4l2Layout layout = set_format(device, format, chosen_size(device, options));
  return {layout, set_rate(device, layout, options.rate_hz)};
}

}  // namespace knuckle
