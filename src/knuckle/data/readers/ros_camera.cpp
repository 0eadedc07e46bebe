// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/ros_camera.h"

#include <algorithm>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr std::string_view kHowToGiveACamera = "give the camera by ?camera=FILE.toml";

bool is_rectified(std::string_view topic) {
  return topic.substr(topic.rfind('/') + 1).starts_with("image_rect");
}

/// Both models are OpenCV's, with its order of coefficients.
void set_distortion(const RosCameraInfo& info, std::string_view where, Camera& camera) {
  if (std::ranges::all_of(info.d, [](double value) { return value == 0.0; })) return;
  const bool is_known =
      info.distortion_model == "plumb_bob" || info.distortion_model == "rational_polynomial";
  if (!is_known || info.d.size() > camera.distortion.size()) {
    fail(
        "{}: has the distortion '{:.40}' with {} coefficients, expected plumb_bob or rational_polynomial; {}",
        where, printable(info.distortion_model), info.d.size(), kHowToGiveACamera);
  }
  std::ranges::copy(info.d, camera.distortion.begin());
}

}  // namespace

Camera camera_of(const RosCameraInfo& info, std::string_view image_topic, std::string_view where) {
  constexpr auto kMostPixels = static_cast<std::uint32_t>(limits::kImageSide);
  if (info.width > kMostPixels || info.height > kMostPixels) {
    fail("{}: says {}x{} pixels, expected at most {} a side", where, info.width, info.height, kMostPixels);
  }
  Camera camera;
  camera.width = static_cast<int>(info.width);
  camera.height = static_cast<int>(info.height);
  const bool takes_p = is_rectified(image_topic) && info.p[0] != 0.0;
  camera.fx = takes_p ? info.p[0] : info.k[0];
  camera.fy = takes_p ? info.p[5] : info.k[4];
  camera.cx = takes_p ? info.p[2] : info.k[2];
  camera.cy = takes_p ? info.p[6] : info.k[5];
  if (camera.fx == 0.0) fail("{}: the camera was not calibrated; {}", where, kHowToGiveACamera);
  if (!is_rectified(image_topic)) set_distortion(info, where, camera);
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: {}; {}", where, error.what(), kHowToGiveACamera);
  }
  return camera;
}

std::string camera_topic_of(std::string_view image_topic) {
  constexpr std::string_view kRealSenseImage = "/image/data";
  if (image_topic.ends_with(kRealSenseImage)) {
    image_topic.remove_suffix(kRealSenseImage.size());
    return fmt::format("{}/info/camera_info", image_topic);
  }
  return fmt::format("{}camera_info", image_topic.substr(0, image_topic.rfind('/') + 1));
}

}  // namespace knuckle
