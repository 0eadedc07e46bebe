// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "knuckle/core/camera.h"
#include "knuckle/synth/pose/hand_sampler.h"
#include "knuckle/synth/pose/motion_options.h"
#include "knuckle/synth/scene/placement_options.h"
#include "knuckle/synth/scene/scene_options.h"
#include "knuckle/synth/sensor/sensor.h"

namespace knuckle {

/// Whose hands are seen, and which.
struct PeopleOptions {
  std::string file;  ///< body (.model), relative to the manifest; empty: MakeHuman's, as set-up fetched it
  int people = 100;  ///< different people, [1, 100000]; each frame (or sequence) shows one of them
  double bone_spread = 0.05;  ///< deviation of each hand bone's length from its share, [0, 0.2]

  std::string side = "right";  ///< right | left | both: left hands are mirror images of right ones
  std::string skinning =
      "dual_quaternion";  ///< dual_quaternion | linear, as Blender's armatures do by default

  void visit(OptionVisitor& visitor);
};

/// Through which camera.
struct ManifestCamera {
  Camera camera;  ///< default: that of the sensor's preset; of none: 320 x 240, f = 224 px, centred
  double focal_spread = 0.0;  ///< focal lengths differ from frame to frame by up to this part, [0, 0.5]

  ManifestCamera();
  void visit(OptionVisitor& visitor);
};

/// A data set that is rendered on demand: everything that a frame depends on, but its number.
struct Manifest {
  std::filesystem::path path;
  std::uint64_t seed = 1;
  int frames = 1000;      ///< [1, 100000000]
  double rate_hz = 30.0;  ///< frame i is seen at i / rate_hz seconds, (0, 10000] [1/s]
  PeopleOptions body;
  ManifestCamera camera;
  HandPoseOptions pose;
  MotionOptions motion;
  PlacementOptions placement;
  SceneOptions scene;
  SensorOptions sensor;
  std::string resolved;  ///< the manifest as TOML with every default filled in

  void visit(OptionVisitor& visitor);  ///< the keys outside tables: seed, frames, rate_hz
};

/// Reads a manifest (TOML; manifests/demo.toml documents all keys). `preset` in `[sensor]` sets camera and
/// sensor (sensor_presets.h); the keys of `[camera]` and `[sensor]` then change single values of it. Throws
/// an Error that names file, line and key where a key is unknown, of the wrong type, or out of range.
Manifest load_manifest(const std::filesystem::path& path);

}  // namespace knuckle
