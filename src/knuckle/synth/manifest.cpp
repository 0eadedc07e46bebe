// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/manifest.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string_view>
#include <vector>

#include "knuckle/synth/sensor/sensor_presets.h"

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 3> kSides = {"right", "left", "both"};
constexpr std::array<std::string_view, 2> kSkinnings = {"dual_quaternion", "linear"};
constexpr std::array<std::string_view, 2> kModels = {"projective", "orthographic"};

template <class... Options>
void read_table(const OptionTable& manifest, std::string_view name, Options&... options) {
  const OptionTable table = manifest.table(name);
  (table.read(options), ...);
  table.finish();
}

/// Camera and sensor of the preset that `[sensor]` names.
void apply_preset(const OptionTable& manifest_table, Manifest& manifest) {
  const auto names = sensor_preset_names();
  const SensorPreset preset =
      sensor_preset(manifest_table.table("sensor").choice_or("preset", names.front(), names));
  manifest.camera.camera = preset.camera;
  manifest.sensor = preset.sensor;
}

void check_scene(const OptionTable& manifest_table, const Manifest& manifest) {
  if (manifest.scene.is_active() && manifest.camera.camera.model != CameraModel::projective) {
    manifest_table.table("camera").fail_at("model", "is orthographic, but [scene] needs a projective camera");
  }
  if (manifest.scene.touching_share > 0.0 && manifest.scene.second_share > 0.0 &&
      manifest.motion.is_smooth() && manifest.scene.second_pass_frames == 0) {
    manifest_table.table("scene").fail_at(
        "touching_share", "is not 0, but the motion is smooth and second_pass_frames is 0: hands would part");
  }
  if (manifest.scene.second_pass_frames > 0 && !manifest.motion.is_smooth()) {
    manifest_table.table("scene").fail_at("second_pass_frames", "is not 0, but the motion is not smooth");
  }
  if (manifest.motion.sequence_frames > 0 && !manifest.motion.is_smooth()) {
    manifest_table.table("pose").fail_at("sequence_frames", "is not 0, but the motion is not smooth");
  }
  if (manifest.scene.empty_share > 0.0 && manifest.motion.is_smooth()) {
    manifest_table.table("scene").fail_at("empty_share",
                                          "is not 0, but the motion is smooth: each frame has a hand");
  }
}

void check_sensor(const OptionTable& manifest_table, const Manifest& manifest) {
  const auto fault = fault_of(manifest.sensor, manifest.camera.camera);
  if (fault) manifest_table.table("sensor").fail_at(fault->key, fault->message);
}

}  // namespace

void PeopleOptions::visit(OptionVisitor& visitor) {
  visitor.text("file", file);
  visitor.integer("people", people, closed(1, 100000));
  visitor.real("bone_spread", bone_spread, closed(0, 0.2));
  visitor.choice("side", side, kSides);
  visitor.choice("skinning", skinning, kSkinnings);
}

ManifestCamera::ManifestCamera()
    : camera{.width = 320, .height = 240, .fx = 224.0, .fy = 224.0, .cx = 159.5, .cy = 119.5} {}

void ManifestCamera::visit(OptionVisitor& visitor) {
  std::string model(kModels[camera.model == CameraModel::orthographic ? 1 : 0]);
  visitor.choice("model", model, kModels);
  camera.model = model == kModels[1] ? CameraModel::orthographic : CameraModel::projective;
  visitor.integer("width", camera.width, closed(1, 8192));
  visitor.integer("height", camera.height, closed(1, 8192));
  visitor.real("fx", camera.fx, open_closed(0, 100000));
  visitor.real("fy", camera.fy, open_closed(0, 100000));
  visitor.real("cx", camera.cx, closed(-10000, 10000));
  visitor.real("cy", camera.cy, closed(-10000, 10000));
  std::vector<double> distortion(camera.distortion.begin(), camera.distortion.end());
  visitor.reals("distortion", distortion, closed(-100, 100), 0, camera.distortion.size());
  camera.distortion.fill(0.0);
  std::ranges::copy(distortion, camera.distortion.begin());
  visitor.real("focal_spread", focal_spread, closed(0, 0.5));
}

void Manifest::visit(OptionVisitor& visitor) {
  visitor.seed("seed", seed);
  visitor.integer("frames", frames, closed(1, 100000000));
  visitor.real("rate_hz", rate_hz, open_closed(0, 10000));
}

Manifest load_manifest(const std::filesystem::path& path) {
  const OptionTable table = OptionTable::load(path);
  Manifest manifest;
  manifest.path = path;
  table.read(manifest);
  apply_preset(table, manifest);
  read_table(table, "body", manifest.body);
  read_table(table, "camera", manifest.camera);
  read_table(table, "pose", manifest.pose, manifest.motion);
  read_table(table, "placement", manifest.placement);
  read_table(table, "scene", manifest.scene);
  read_table(table, "sensor", manifest.sensor);
  table.finish();
  check(manifest.pose, path.string() + ": [pose]");
  check(manifest.placement, path.string() + ": [placement]");
  check(manifest.scene, path.string() + ": [scene]");
  check_scene(table, manifest);
  check_sensor(table, manifest);
  try {
    check(manifest.camera.camera);
  } catch (const Error& error) {
    fail("{}: [camera]: {}", path.string(), error.what());
  }
  manifest.resolved = table.resolved_toml();
  return manifest;
}

}  // namespace knuckle
