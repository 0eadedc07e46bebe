// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/intrinsics.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/data/readers/folder_format.h"

namespace knuckle {
namespace {

constexpr double kWidestFieldOfView = 175.0;  // [degrees]
constexpr double kGuessedFieldOfView = 60.0;  // [degrees]

}  // namespace

void IntrinsicsOptions::visit(OptionVisitor& visitor) {
  visitor.text("camera", camera);
  visitor.real("fov_deg", fov_deg, closed(0, kWidestFieldOfView));
}

Camera camera_of_field_of_view(int width, int height, double fov_deg) {
  const double focal_length = width / (2.0 * std::tan(fov_deg * std::numbers::pi / 360.0));
  return {.model = CameraModel::projective,
          .width = width,
          .height = height,
          .fx = focal_length,
          .fy = focal_length,
          .cx = (width - 1) / 2.0,
          .cy = (height - 1) / 2.0,
          .distortion = {}};
}

std::optional<Camera> camera_file_of(const IntrinsicsOptions& options) {
  if (options.camera.empty()) return std::nullopt;
  if (options.fov_deg > 0.0)
    fail("camera={} and fov_deg both say what the camera is; leave one out", options.camera);
  return read_camera_file(options.camera);
}

Intrinsics find_intrinsics(const IntrinsicsOptions& options, std::optional<Intrinsics> reported, int width,
                           int height, UnknownIntrinsics unknown, std::string_view where) {
  if (const auto camera = camera_file_of(options)) {
    if (camera->width != width || camera->height != height) {
      fail("{}: sends images of {}x{}, but the camera of {} has {}x{}", where, width, height, options.camera,
           camera->width, camera->height);
    }
    return {*camera, "from " + options.camera};
  }
  if (options.fov_deg > 0.0) {
    return {camera_of_field_of_view(width, height, options.fov_deg),
            fmt::format("rough, from a field of view of {:g} degrees", options.fov_deg)};
  }
  if (reported) return *std::move(reported);
  if (unknown == UnknownIntrinsics::guess) {
    return {camera_of_field_of_view(width, height, kGuessedFieldOfView), ""};
  }
  fail(
      "{}: its intrinsics are not known; say them by ?camera=FILE.toml, or roughly by ?fov_deg=, the "
      "horizontal "
      "field of view of its data sheet (docs/cameras.md)",
      where);
}

}  // namespace knuckle
