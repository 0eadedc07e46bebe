// SPDX-License-Identifier: Apache-2.0
// Renders frames of one person and writes all that another program needs to render them, too (see
// scripts/blender_render.py), with what Knuckle made of them and how fast.
//
//     knuckle_frame_dump BODY.h5|makehuman OUT.h5 FRAMES

#include <charconv>
#include <chrono>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/hdf5_file.h"
#include "knuckle/core/parallel.h"
#include "knuckle/synth/body_file.h"
#include "knuckle/synth/body_rig.h"
#include "knuckle/synth/makehuman_import.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/motion.h"
#include "knuckle/synth/people.h"
#include "knuckle/synth/rasteriser.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr int kTimedFrames = 400;

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
  return shaped_body(body, shape_coefficients(body, sampled_person(body, random)));
}

void draw(PosedFrame& frame, const ShapedBody& person, const Camera& camera) {
  frame.posed = posed_body(person, frame.pose);
  frame.rendering =
      render({frame.posed.vertices, person.body->faces}, camera, {.culling = FaceCulling::back_faces});
  frame.mask = mask_of(frame.rendering, person.body->is_hand);
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Frames a second on all threads: the pose is there, the person is skinned, drawn and masked.
double drawing_rate(const std::vector<PosedFrame>& frames, const ShapedBody& person, const Camera& camera) {
  const auto draw_again = [&](std::int64_t i) {
    PosedFrame frame{frames[static_cast<std::size_t>(i) % frames.size()].pose, {}, {}, {}};
    draw(frame, person, camera);
  };
  return kTimedFrames / seconds_of([&] { parallel_for(kTimedFrames, draw_again); });
}

/// Frames a second on all threads as `synthetic:` gives them: also the choice of the pose, and noise.
double source_rate(const Manifest& manifest, const std::shared_ptr<const Body>& body) {
  const auto source = create_synthetic(manifest, body);
  const auto read = [&](std::int64_t i) { static_cast<void>(source->read(i)); };
  read(0);
  return kTimedFrames / seconds_of([&] { parallel_for(kTimedFrames, read); });
}

/// Rows of float arrays, one a frame.
template <class Get>
void write_frames(Hdf5File& file, const std::string& name, const std::vector<std::uint64_t>& shape,
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

void write_person(Hdf5File& file, const ShapedBody& person) {
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

void write_frame_arrays(Hdf5File& file, const std::vector<PosedFrame>& frames, const Camera& camera) {
  const std::uint64_t bones = frames[0].pose.rotations.size();
  const std::uint64_t vertices = frames[0].posed.vertices.size();
  write_frames(file, "rotations_wxyz", {bones, 4}, frames, [](const PosedFrame& frame, auto& values) {
    for (const auto& q : frame.pose.rotations) values.insert(values.end(), {q.w(), q.x(), q.y(), q.z()});
  });
  write_frames(file, "camera_from_body", {4, 4}, frames, [](const PosedFrame& frame, auto& values) {
    for (int i = 0; i < 16; ++i) values.push_back(frame.pose.camera_from_body.matrix()(i / 4, i % 4));
  });
  write_frames(file, "vertices", {vertices, 3}, frames, [](const PosedFrame& frame, auto& values) {
    append_points(frame.posed.vertices, values);
  });
  write_frames(file, "landmarks", {kSupersetSize, 3}, frames, [](const PosedFrame& frame, auto& values) {
    append_points(frame.posed.landmarks, values);
  });
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

void dump(std::string_view kind, const std::string& out, int frame_count) {
  const auto body = std::make_shared<const Body>(kind == "makehuman" ? makehuman_body(makehuman_folder())
                                                                     : load_body(kind));
  Manifest manifest;
  manifest.path = "frame_dump";
  manifest.frames = frame_count;
  const Camera& camera = manifest.camera.camera;
  const ShapedBody person = person_of(*body, kind);
  const BodyRig rig(person);
  const std::vector<PosedFrame> frames = drawn_frames(rig, manifest);

  const std::string body_file = out + ".body.h5";
  save_body(*body, body_file);
  Hdf5File file = Hdf5File::create(out);
  file.set_attribute("body", body_file);
  file.set_attribute("width", camera.width);
  file.set_attribute("height", camera.height);
  for (const auto& [name, value] :
       {std::pair{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}}) {
    file.set_attribute(name, value);
  }
  write_person(file, person);
  write_frame_arrays(file, frames, camera);
  manifest.frames = kTimedFrames;
  file.set_attribute("threads", thread_count());
  file.set_attribute("drawn_frames_per_second", drawing_rate(frames, person, camera));
  file.set_attribute("source_frames_per_second", source_rate(manifest, body));
  file.close();
}

}  // namespace
}  // namespace knuckle

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  int frames = 0;
  if (arguments.size() == 3) {
    const std::string& text = arguments[2];
    std::from_chars(text.data(), text.data() + text.size(), frames);
  }
  if (frames < 1) {
    std::fputs("usage: knuckle_frame_dump BODY.h5|makehuman OUT.h5 FRAMES\n", stderr);
    return 2;
  }
  try {
    knuckle::dump(arguments[0], arguments[1], frames);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "knuckle_frame_dump: %s\n", error.what());
    return 1;
  }
  return 0;
}
