// SPDX-License-Identifier: Apache-2.0
// Renders frames of one person and writes all that another program needs to render them, too (see
// scripts/blender_render.py), with what Knuckle made of them and how fast.
//
//     knuckle_frame_dump BODY.model|makehuman OUT.h5 [--frames N] [--camera WIDTH,HEIGHT,FX,FY,CX,CY]
//     [--time]

#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/hand/body_file.h"
#include "knuckle/hand/body_rig.h"
#include "knuckle/storage/hdf5/hdf5_writer.h"
#include "knuckle/synth/makehuman/makehuman_import.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/people/people.h"
#include "knuckle/synth/pose/motion.h"
#include "knuckle/synth/render/rasteriser.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr double kBoneSpread = 0.05;  ///< the default of manifests
constexpr int kTimedFrames = 800;

struct Arguments {
  std::string body;
  std::string out;
  int frames = 20;
  std::vector<double> camera;
  bool is_timed = false;
};

struct PosedFrame {
  BodyPose pose;
  PosedBody posed;
  Rendering rendering;
  Image<std::uint8_t> mask;
};

/// MakeHuman's body as a sampled adult; any other body as its template.
ShapedBody person_of(const Body& body, std::string_view kind) {
  if (kind != "makehuman") return shaped_body(body, std::vector<double>(body.shapedirs.size(), 0.0));
  Random random(kSeed);
  return shaped_body(body, sampled_person(body, kBoneSpread, random));
}

void draw(PosedFrame& frame, const ShapedBody& person, const Camera& camera) {
  frame.posed = posed_body(person, frame.pose);
  frame.rendering =
      render({frame.posed.vertices, person.body->faces}, camera, {.culling = FaceCulling::back_faces});
  frame.mask = mask_of(frame.rendering, person.body->is_hand);
}

/// What a frame costs when many are made on all threads.
struct Cost {
  double frames_per_second = 0.0;
  double cpu_seconds_per_frame = 0.0;  ///< of all threads together: does not depend on what else runs
};

Cost cost_of(const std::function<void(std::int64_t)>& frame) {
  const std::clock_t cpu_start = std::clock();
  const auto start = std::chrono::steady_clock::now();
  parallel_for(kTimedFrames, frame);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const double cpu_seconds = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC;
  return {kTimedFrames / seconds.count(), cpu_seconds / kTimedFrames};
}

/// The pose is there; the person is skinned, drawn and masked.
Cost drawing_cost(const std::vector<PosedFrame>& frames, const ShapedBody& person, const Camera& camera) {
  return cost_of([&](std::int64_t i) {
    PosedFrame frame{frames[static_cast<std::size_t>(i) % frames.size()].pose, {}, {}, {}};
    draw(frame, person, camera);
  });
}

/// As `synthetic:` gives frames: also the choice of the pose, and noise.
Cost source_cost(Manifest manifest, const std::shared_ptr<const Body>& body) {
  manifest.frames = kTimedFrames;
  const auto source = create_synthetic(manifest, body);
  return cost_of([&](std::int64_t i) { static_cast<void>(source->read(i)); });
}

void write_cost(Hdf5Writer& file, const std::string& name, const Cost& cost) {
  file.set_attribute(name + "_frames_per_second", cost.frames_per_second);
  file.set_attribute(name + "_cpu_seconds_per_frame", cost.cpu_seconds_per_frame);
}

/// Rows of float arrays, one per frame.
template <class Get>
void write_frames(Hdf5Writer& file, const std::string& name, const std::vector<std::uint64_t>& shape,
                  const std::vector<PosedFrame>& frames, Get append) {
  std::vector<float> values;
  for (const PosedFrame& frame : frames) append(frame, values);
  std::vector<std::uint64_t> full{frames.size()};
  full.insert(full.end(), shape.begin(), shape.end());
  file.write<float>(name, full, values.data());
}

void append_points(const auto& points, std::vector<float>& values) {
  for (const auto& point : points) {
    for (int axis = 0; axis < 3; ++axis) values.push_back(static_cast<float>(point[axis]));
  }
}

void write_person(Hdf5Writer& file, const ShapedBody& person) {
  std::vector<float> values;
  append_points(person.vertices, values);
  file.write<float>("rest_vertices", {person.vertices.size(), 3}, values.data());
  values.clear();
  append_points(person.joints, values);
  file.write<float>("rest_joints", {person.joints.size(), 3}, values.data());
  values.clear();
  append_points(person.landmarks, values);
  file.write<float>("rest_landmarks", {person.landmarks.size(), 3}, values.data());
}

void write_frame_arrays(Hdf5Writer& file, const std::vector<PosedFrame>& frames, const Camera& camera) {
  const std::uint64_t bones = frames[0].pose.rotations.size();
  const std::uint64_t vertices = frames[0].posed.vertices.size();
  write_frames(file, "rotations_wxyz", {bones, 4}, frames, [](const PosedFrame& frame, auto& values) {
    for (const auto& q : frame.pose.rotations) values.insert(values.end(), {q.w(), q.x(), q.y(), q.z()});
  });
  write_frames(file, "camera_from_body", {4, 4}, frames, [](const PosedFrame& frame, auto& values) {
    for (int i = 0; i < 16; ++i) values.push_back(frame.pose.camera_from_body.matrix()(i / 4, i % 4));
  });
  write_frames(file, "vertices", {vertices, 3}, frames,
               [](const PosedFrame& frame, auto& values) { append_points(frame.posed.vertices, values); });
  write_frames(file, "landmarks", {kSupersetSize, 3}, frames,
               [](const PosedFrame& frame, auto& values) { append_points(frame.posed.landmarks, values); });
  const auto height = static_cast<std::uint64_t>(camera.height);
  const auto width = static_cast<std::uint64_t>(camera.width);
  write_frames(file, "depth_mm", {height, width}, frames, [](const PosedFrame& frame, auto& values) {
    const auto pixels = frame.rendering.depth_mm.pixels();
    values.insert(values.end(), pixels.begin(), pixels.end());
  });
  write_frames(file, "mask", {height, width}, frames, [](const PosedFrame& frame, auto& values) {
    for (const std::uint8_t pixel : frame.mask.pixels()) values.push_back(pixel);
  });
}

std::vector<PosedFrame> drawn_frames(const BodyRig& rig, const Manifest& manifest) {
  const PostureOptions options{manifest.pose, manifest.placement, manifest.motion};
  const Camera& camera = manifest.camera.camera;
  std::vector<PosedFrame> frames(static_cast<std::size_t>(manifest.frames));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto index = static_cast<std::int64_t>(i);
    const PlacedPosture placed = posture_of_frame(rig, camera, options, kSeed, index);
    frames[i].pose = rig.pose(placed.posture, placed.camera_from_body);
    draw(frames[i], rig.person(), camera);
  }
  return frames;
}

Camera camera_of(const std::vector<double>& numbers) {
  Camera camera;
  camera.width = static_cast<int>(numbers[0]);
  camera.height = static_cast<int>(numbers[1]);
  camera.fx = numbers[2];
  camera.fy = numbers[3];
  camera.cx = numbers[4];
  camera.cy = numbers[5];
  check(camera);
  return camera;
}

void write_camera(Hdf5Writer& file, const Camera& camera) {
  file.set_attribute("width", camera.width);
  file.set_attribute("height", camera.height);
  file.set_attribute("fx", camera.fx);
  file.set_attribute("fy", camera.fy);
  file.set_attribute("cx", camera.cx);
  file.set_attribute("cy", camera.cy);
}

void dump(const Arguments& arguments) {
  const bool is_makehuman = arguments.body == "makehuman";
  const auto body = std::make_shared<const Body>(is_makehuman ? makehuman_body(makehuman_folder())
                                                              : load_body(arguments.body));
  Manifest manifest;
  manifest.frames = arguments.frames;
  if (!arguments.camera.empty()) manifest.camera.camera = camera_of(arguments.camera);
  const Camera& camera = manifest.camera.camera;
  const ShapedBody person = person_of(*body, arguments.body);
  const BodyRig rig(person);
  const std::vector<PosedFrame> frames = drawn_frames(rig, manifest);

  const std::string body_file = arguments.out + ".body.model";
  save_body(*body, body_file);
  Hdf5Writer file = Hdf5Writer::create(arguments.out);
  file.set_attribute("body", body_file);
  write_camera(file, camera);
  write_person(file, person);
  write_frame_arrays(file, frames, camera);
  if (arguments.is_timed) {
    file.set_attribute("threads", thread_count());
    write_cost(file, "drawing", drawing_cost(frames, person, camera));
    write_cost(file, "source", source_cost(manifest, body));
  }
  file.close();
}

}  // namespace
}  // namespace knuckle

int main(int argc, char** argv) {
  knuckle::Arguments arguments;
  CLI::App app("Frames that Knuckle rendered, with all that another renderer needs to render them");
  app.add_option("body", arguments.body, "body file, or makehuman")->required();
  app.add_option("out", arguments.out, "dump to write (.h5)")->required();
  app.add_option("--frames", arguments.frames, "how many")->check(CLI::PositiveNumber);
  app.add_option("--camera", arguments.camera, "width,height,fx,fy,cx,cy")->delimiter(',')->expected(6);
  app.add_flag("--time", arguments.is_timed, "also measure how fast frames are made");
  CLI11_PARSE(app, argc, argv);
  try {
    knuckle::dump(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "knuckle_frame_dump: %s\n", error.what());
    return 1;
  }
  return 0;
}
