// SPDX-License-Identifier: Apache-2.0
#include "knuckle/data/readers/azure_calibration.h"

#include <array>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/limits.h"
#include "knuckle/core/named_table.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kDepthPurpose = "CALIBRATION_CameraPurposeDepth";
constexpr std::string_view kBrownConrady = "CALIBRATION_LensDistortionModelBrownConrady";
constexpr std::string_view kRational6KT = "CALIBRATION_LensDistortionModelRational6KT";
constexpr const char* kHowToGiveACamera = "give the camera by ?camera=FILE.toml";

constexpr int kSensorSide = 1024;  // [px]

/// What a depth mode makes of the sensor's pixels.
struct DepthMode {
  std::string_view name;
  int binning;  ///< how many pixels a side become one
  int left;     ///< where the image begins, in its own pixels
  int top;
  int width;
  int height;
};

// "Azure Kinect DK hardware specifications" has the sizes; where the narrow image begins is what the SDK's
// makers told ("How is the IR image in passive mode turned into NFOV_UNBINNED mode", issue 930).
constexpr std::array kModes{
    DepthMode{"NFOV_UNBINNED", 1, 192, 180, 640, 576},
    DepthMode{"NFOV_2X2BINNED", 2, 96, 90, 320, 288},
    DepthMode{"WFOV_UNBINNED", 1, 0, 0, 1024, 1024},
    DepthMode{"WFOV_2X2BINNED", 2, 0, 0, 512, 512},
};

/// The value under a key; null where there is none.
const Json& at(const Json& object, const char* key) {
  static const Json nothing;
  const auto value = object.is_object() ? object.find(key) : object.end();
  return value == object.end() ? nothing : *value;
}

std::string text_at(const Json& object, const char* key) {
  const Json& value = at(object, key);
  return value.is_string() ? value.get<std::string>() : "";
}

Json parse_json(std::string_view text, std::string_view where) {
  const auto is_shallow = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > limits::kNesting) fail("{}: its values lie more than {} deep", where, limits::kNesting);
    return true;
  };
  Json json = Json::parse(text, is_shallow, /*allow_exceptions=*/false);
  if (json.is_discarded()) fail("{}: is not JSON; {}", where, kHowToGiveACamera);
  return json;
}

const Json& depth_camera_of(const Json& json, std::string_view where) {
  const Json& cameras = at(at(json, "CalibrationInformation"), "Cameras");
  if (cameras.is_array()) {
    for (const Json& camera : cameras) {
      if (text_at(camera, "Purpose") == kDepthPurpose) return camera;
    }
  }
  fail("{}: has no depth camera; {}", where, kHowToGiveACamera);
}

/// Parts of the sensor's sides, coefficients of the lens: cx, cy, fx, fy, k1 to k6, the centre of distortion
/// (2), p2, p1.
using Parameters = std::array<double, 14>;

Parameters parameters_of(const Json& intrinsics, std::string_view where) {
  const Json& list = at(intrinsics, "ModelParameters");
  Parameters parameters{};
  const bool is_list = list.is_array() && list.size() >= parameters.size();
  for (std::size_t i = 0; is_list && i < parameters.size(); ++i) {
    if (!list[i].is_number()) fail("{}: parameter {} of the depth camera is no number", where, i);
    parameters[i] = list[i].get<double>();
  }
  if (!is_list) {
    fail("{}: the depth camera has {} parameters, expected {}; {}", where, list.is_array() ? list.size() : 0,
         parameters.size(), kHowToGiveACamera);
  }
  return parameters;
}

/// Rational 6KT counts the shift of the lens in another way, and moves the centre of distortion: without
/// both it is the same as Brown and Conrady's.
void require_known_lens(const std::string& model, const Parameters& parameters, std::string_view where) {
  const bool has_shift =
      parameters[10] != 0.0 || parameters[11] != 0.0 || parameters[12] != 0.0 || parameters[13] != 0.0;
  if (model == kBrownConrady && parameters[10] == 0.0 && parameters[11] == 0.0) return;
  if (model == kRational6KT && !has_shift) return;
  fail("{}: the depth camera has the lens '{:.60}'{}, expected BrownConrady; {}", where, printable(model),
       has_shift ? " with a shift" : "", kHowToGiveACamera);
}

int side_of(const Json& camera, const char* key, std::string_view where) {
  const Json& value = at(camera, key);
  if (!value.is_number_integer() || value.get<double>() != kSensorSide)
    fail("{}: {} is not {}, that of an Azure Kinect; {}", where, key, kSensorSide, kHowToGiveACamera);
  return kSensorSide;
}

}  // namespace

Camera parse_azure_calibration(std::string_view text, std::string_view mode, std::string_view where) {
  const DepthMode* const found = row_named(kModes, mode);
  if (found == nullptr) fail("{}: {}", where, unknown_name("depth mode", printable(mode), names_of(kModes)));
  const Json json = parse_json(text, where);
  const Json& depth = depth_camera_of(json, where);
  const Json& intrinsics = at(depth, "Intrinsics");
  const Parameters p = parameters_of(intrinsics, where);
  require_known_lens(text_at(intrinsics, "ModelType"), p, where);
  const double sensor_width = static_cast<double>(side_of(depth, "SensorWidth", where)) / found->binning;
  const double sensor_height = static_cast<double>(side_of(depth, "SensorHeight", where)) / found->binning;
  Camera camera;
  camera.width = found->width;
  camera.height = found->height;
  camera.fx = p[2] * sensor_width;
  camera.fy = p[3] * sensor_height;
  // The calibration counts from the corner of the first pixel.
  camera.cx = p[0] * sensor_width - found->left - 0.5;
  camera.cy = p[1] * sensor_height - found->top - 0.5;
  camera.distortion = {p[4], p[5], p[13], p[12], p[6], p[7], p[8], p[9]};
  try {
    check(camera);
  } catch (const Error& error) {
    fail("{}: {}; {}", where, error.what(), kHowToGiveACamera);
  }
  return camera;
}

}  // namespace knuckle
