// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/synth/sensor/sensor.h"

namespace knuckle {

/// A camera with what its sensor does.
struct SensorPreset {
  Camera camera;
  SensorOptions sensor;
};

/// Names of all presets; the first, `paper`, is what a manifest has that names none.
std::span<const std::string_view> sensor_preset_names();

/// The preset of that name:
///
/// - `paper`: the framework paper's synthetic frames: the Creative's camera, Gaussian noise of 3 mm, whole
///   millimetres, nothing else.
/// - `creative`: Creative Interactive Gesture Camera (SoftKinetic DS325), time of flight.
/// - `pico`: PMD CamBoard pico, time of flight.
/// - `kinect_v1`: Microsoft's first Kinect, structured light.
/// - `kinect_v2`: Microsoft's second Kinect, time of flight.
/// - `sr300`: Intel RealSense SR300, coded light.
///
/// docs/synthetic-data.md has the source of every value. Throws an Error that lists the names where it is
/// none of them.
SensorPreset sensor_preset(std::string_view name);

}  // namespace knuckle
