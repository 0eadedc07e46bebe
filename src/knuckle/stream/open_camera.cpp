// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/open_camera.h"

#include <array>
#include <optional>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/core/text.h"
#include "knuckle/stream/oni_source.h"
#include "knuckle/stream/process_stream.h"
#include "knuckle/stream/v4l2_stream.h"

namespace knuckle {
namespace {

std::unique_ptr<CameraStream> open_v4l2(const SourceSpec& spec, UnknownIntrinsics unknown) {
  if (spec.path.empty()) fail("{}: names no device; expected v4l2:/dev/videoN", spec.text);
  return std::make_unique<V4l2Stream>(spec.path.string(), options_from<V4l2Options>(spec), unknown);
}

std::unique_ptr<CameraProcess> start_camera(std::vector<std::string> arguments, const SourceSpec& spec) {
  return std::make_unique<CameraProcess>(camera_program(), std::move(arguments), spec.text);
}

std::unique_ptr<CameraStream> open_freenect(const SourceSpec& spec, UnknownIntrinsics unknown) {
  constexpr long long kMostKinects = 64;
  const auto options = options_from<FreenectOptions>(spec);
  const std::string index = spec.path.empty() ? "0" : spec.path.string();
  const long long number = parse_integer(index, spec.text);
  if (number < 0 || number >= kMostKinects)
    fail("{}: {} is no number of a Kinect; the first is 0", spec.text, number);
  return std::make_unique<ProcessStream>(
      start_camera({"freenect", std::to_string(number), options.depth}, spec), spec.text, options.intrinsics,
      options.timeout_s, unknown);
}

std::unique_ptr<CameraStream> open_openni2(const SourceSpec& spec, UnknownIntrinsics unknown) {
  auto options = options_from<Openni2Options>(spec);
  const std::optional<Camera> camera = camera_file_of(options.intrinsics);
  if (camera && options.width == 0 && options.height == 0) {
    options.width = camera->width;
    options.height = camera->height;
  }
  return std::make_unique<ProcessStream>(
      start_camera({"openni2", spec.path.string(), std::to_string(options.width),
                    std::to_string(options.height), std::to_string(options.rate_hz)},
                   spec),
      spec.text, options.intrinsics, options.timeout_s, unknown);
}

/// What a library sees; where it cannot be asked, a line that says why.
std::vector<CameraListing> list_of_library(const std::string& kind) {
  std::vector<CameraListing> all;
  try {
    for (const ProcessListing& camera : list_by_process(kind))
      all.push_back({fmt::format("{}:{}", kind, camera.device), camera.name, "depth", true});
  } catch (const Error& error) {
    all.push_back({kind + ":", "", error.what(), false});
  }
  return all;
}

std::vector<CameraListing> list_freenect_cameras() {
  return list_of_library("freenect");
}

std::vector<CameraListing> list_openni2_cameras() {
  return list_of_library("openni2");
}

CameraListing listing_of(const V4l2Listing& device) {
  CameraListing listing{.stream = "v4l2:" + device.path, .device = device.card, .state = device.fault};
  if (!device.fault.empty()) return listing;
  listing.is_usable = !device.formats.empty();
  listing.state = listing.is_usable ? joined(device.formats) : "no depth";
  return listing;
}

std::vector<CameraListing> list_v4l2_cameras() {
  std::vector<CameraListing> all;
  for (const V4l2Listing& device : list_v4l2()) all.push_back(listing_of(device));
  return all;
}

constexpr std::array kCameraKinds{
    CameraKind{"v4l2", "depth cameras that Linux knows as video devices: RealSense and others", true,
               open_v4l2, list_v4l2_cameras},
    CameraKind{"freenect", "the first Kinect, by libfreenect", KNUCKLE_HAS_FREENECT != 0, open_freenect,
               list_freenect_cameras},
    CameraKind{"openni2", "PrimeSense, Asus Xtion, Orbbec and others with a driver for OpenNI2",
               KNUCKLE_HAS_OPENNI2 != 0, open_openni2, list_openni2_cameras},
};

}  // namespace

std::span<const CameraKind> camera_kinds() {
  return kCameraKinds;
}

std::unique_ptr<FrameSource> open_oni(const SourceSpec& spec) {
  const auto options = options_from<OniOptions>(spec);
  if (KNUCKLE_HAS_OPENNI2 == 0)
    fail("{}: this build of Knuckle lacks OpenNI2, which reads such files", spec.text);
  return std::make_unique<OniSource>(spec.path, options);
}

bool names_a_camera(std::string_view text) {
  const std::size_t colon = text.find(':');
  return colon != std::string_view::npos && row_named(kCameraKinds, text.substr(0, colon)) != nullptr;
}

std::unique_ptr<CameraStream> open_camera(std::string_view text, UnknownIntrinsics unknown) {
  const SourceSpec spec = parse_camera_spec(text);
  const CameraKind* const kind = row_named(kCameraKinds, spec.kind);
  if (kind == nullptr)
    fail("{}: {}", text, unknown_name("kind of camera", spec.kind, names_of(kCameraKinds)));
  if (!kind->is_built)
    fail("{}: this build of Knuckle lacks the library for such cameras (docs/cameras.md)", text);
  if (!spec.selection.takes_all())
    fail("{}: first, count and step are for recordings; a camera gives what comes", text);
  return kind->open(spec, unknown);
}

}  // namespace knuckle
