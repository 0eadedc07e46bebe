// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/open_camera.h"

#include <array>

#include "knuckle/core/error.h"
#include "knuckle/core/named_table.h"
#include "knuckle/core/text.h"
#include "knuckle/stream/v4l2_stream.h"

namespace knuckle {
namespace {

std::unique_ptr<CameraStream> open_v4l2(const SourceSpec& spec, UnknownIntrinsics unknown) {
  if (spec.path.empty()) fail("{}: names no device; expected v4l2:/dev/videoN", spec.text);
  return std::make_unique<V4l2Stream>(spec.path.string(), options_from<V4l2Options>(spec), unknown);
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
    CameraKind{"v4l2", "depth cameras that Linux knows as video devices: RealSense and others", true, open_v4l2,
               list_v4l2_cameras},
};

}  // namespace

std::span<const CameraKind> camera_kinds() {
  return kCameraKinds;
}

bool names_a_camera(std::string_view text) {
  const std::size_t colon = text.find(':');
  return colon != std::string_view::npos && row_named(kCameraKinds, text.substr(0, colon)) != nullptr;
}

std::unique_ptr<CameraStream> open_camera(std::string_view text, UnknownIntrinsics unknown) {
  const SourceSpec spec = parse_camera_spec(text);
  const CameraKind* const kind = row_named(kCameraKinds, spec.kind);
  if (kind == nullptr) fail("{}: {}", text, unknown_name("kind of camera", spec.kind, names_of(kCameraKinds)));
  if (!spec.selection.takes_all())
    fail("{}: first, count and step are for recordings; a camera gives what comes", text);
  return kind->open(spec, unknown);
}

}  // namespace knuckle
