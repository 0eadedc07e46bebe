// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/h5_format.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"

namespace knuckle {
namespace {

constexpr std::int8_t kSideRight = 0;
constexpr std::int8_t kSideLeft = 1;
constexpr std::int8_t kSideUnknown = -1;

int size_attribute(const Hdf5File& file, std::string_view name) {
  const double value = file.number_attribute(name);
  if (!(value >= 1 && value <= limits::kImageSide) || value != std::floor(value))
    fail("{}: the attribute '{}' is {}, expected a number of pixels", file.path().string(), name, value);
  return static_cast<int>(value);
}

}  // namespace

std::int8_t code_of(std::optional<HandSide> side) {
  if (!side) return kSideUnknown;
  return *side == HandSide::left ? kSideLeft : kSideRight;
}

std::optional<HandSide> side_of(std::int8_t code, std::string_view where) {
  if (code == kSideUnknown) return std::nullopt;
  if (code == kSideLeft) return HandSide::left;
  if (code == kSideRight) return HandSide::right;
  fail("{}: side is {}, expected {} (right), {} (left) or {} (not known)", where, code, kSideRight, kSideLeft,
       kSideUnknown);
}

Camera read_camera(const Hdf5File& file) {
  const std::string name = file.path().string();
  Camera camera;
  const std::string model = file.text_attribute("camera_model");
  if (model != "projective" && model != "orthographic")
    fail("{}: the attribute 'camera_model' is '{}', expected projective or orthographic", name, model);
  camera.model = model == "orthographic" ? CameraModel::orthographic : CameraModel::projective;
  camera.width = size_attribute(file, "width");
  camera.height = size_attribute(file, "height");
  camera.fx = file.number_attribute("fx");
  camera.fy = file.number_attribute("fy");
  camera.cx = file.number_attribute("cx");
  camera.cy = file.number_attribute("cy");
  const std::vector<double> distortion = file.numbers_attribute("distortion");
  if (distortion.size() != camera.distortion.size()) {
    fail("{}: the attribute 'distortion' has {} numbers, expected {}", name, distortion.size(),
         camera.distortion.size());
  }
  std::ranges::copy(distortion, camera.distortion.begin());
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: {}", name, error.what());
  }
  return camera;
}

}  // namespace knuckle
