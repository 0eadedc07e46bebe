// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"
#include "knuckle/core/options.h"
#include "knuckle/synth/sensor/drop_outs.h"
#include "knuckle/synth/sensor/flying_pixels.h"
#include "knuckle/synth/sensor/infrared.h"
#include "knuckle/synth/sensor/lateral_noise.h"
#include "knuckle/synth/sensor/range_noise.h"
#include "knuckle/synth/sensor/structured_light.h"
#include "knuckle/synth/sensor/window_matching.h"

namespace knuckle {

/// What a sensor makes of exact depths: the `[sensor]` table of a manifest. The default is the paper's model,
/// Gaussian noise of 3 mm in whole millimetres; sensor_presets.h has those of real cameras. The effects come
/// in the order of the fields.
struct SensorOptions {
  double background_mm = 0.0;  ///< a wall behind all; 0 = none, as in the paper, [0, 10000] [mm]
  double jump_mm = 20.0;       ///< neighbours farther apart in depth are two surfaces, [1, 10000] [mm]
  StructuredLightOptions structured_light;
  WindowMatchingOptions matching;
  LateralNoiseOptions lateral;
  FlyingPixelOptions flying;
  InfraredOptions infrared;
  RangeNoiseOptions noise;
  DropOutOptions drop_outs;
  double quantisation_mm = 1.0;  ///< step that depths are rounded to; 0 = not rounded, [0, 100] [mm]

  void visit(OptionVisitor& visitor);

  /// Whether any effect depends on the angle of the surface.
  bool needs_angles() const;
};

/// An option that contradicts another one, or the camera.
struct SensorFault {
  std::string key;
  std::string message;
};
/// The first option that is out of range or contradicts another or the camera; nothing where all is well.
std::optional<SensorFault> fault_of(const SensorOptions& options, const Camera& camera);

/// Throws an Error that starts with `what` and names the option that is out of range or contradicts another.
void check(const SensorOptions& options, const Camera& camera, std::string_view what);

/// What lies before a sensor, exactly.
struct SeenSurfaces {
  Image<float> depth_mm;  ///< along z; 0 where nothing is
  Image<float> cosines;  ///< of the angle between line of sight and normal, 0 where nothing is; may be empty:
                         ///< all surfaces face the camera
};

/// What the sensor gives.
struct SensorImages {
  Image<float> depth_mm;          ///< 0 = no measurement
  Image<std::uint16_t> infrared;  ///< amplitude in counts; empty where the options ask for none
};

/// Looks at surfaces with a sensor. Each pixel has its own random numbers, made from `seed` and its place:
/// the same bits in any order of work. Throws where the options are out of range or contradict each other.
SensorImages measured(SeenSurfaces surfaces, const Camera& camera, const SensorOptions& options,
                      std::uint64_t seed);

}  // namespace knuckle
