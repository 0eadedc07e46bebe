// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/image_io.h"
#include "knuckle/eval/drawing.h"
#include "knuckle/pipeline/open_source.h"

namespace knuckle::cli {
namespace {

struct InspectArguments {
  std::string source;
  std::int64_t frame = 0;
  std::filesystem::path png;
};

/// Depth statistics of one frame.
struct DepthSummary {
  std::int64_t valid_pixels = 0;
  float nearest_mm = 0.0f;
  float farthest_mm = 0.0f;
};

DepthSummary summary_of(const Image<float>& depth_mm) {
  DepthSummary summary;
  for (const float depth : depth_mm.pixels()) {
    if (!(depth > 0.0f)) continue;
    summary.nearest_mm = summary.valid_pixels == 0 ? depth : std::min(summary.nearest_mm, depth);
    summary.farthest_mm = std::max(summary.farthest_mm, depth);
    ++summary.valid_pixels;
  }
  return summary;
}

void print_camera(const Camera& camera) {
  fmt::print("camera       {}, {} x {} px, fx {:g}, fy {:g}, cx {:g}, cy {:g} (pixel-centre coordinates)\n",
             camera.model == CameraModel::projective ? "projective" : "orthographic", camera.width,
             camera.height, camera.fx, camera.fy, camera.cx, camera.cy);
  if (camera.is_distorted()) fmt::print("distortion   {}\n", fmt::join(camera.distortion, ", "));
}

void print_frame(const Frame& frame, std::int64_t index) {
  const DepthSummary depth = summary_of(frame.depth_mm);
  fmt::print("frame        {} '{}': {} of {} pixels measured, {:g} to {:g} mm\n", index, frame.name,
             depth.valid_pixels, frame.depth_mm.size(), depth.nearest_mm, depth.farthest_mm);
  fmt::print("infrared     {}\n", frame.infrared.empty() ? "no" : "yes");
  fmt::print("mask         {}\n", frame.mask.empty() ? "no" : "yes");
  if (!frame.truth) return;
  const auto known =
      std::ranges::count_if(frame.truth->joints, [](const ImagePoint& p) { return !p.is_missing(); });
  fmt::print("truth        {} of {} joints known\n", known, frame.truth->joints.size());
}

void run_inspect(const InspectArguments& arguments) {
  const auto source = open_source(arguments.source);
  if (arguments.frame >= source->size()) {
    fail("{}: frame {} was asked for, it has {}", arguments.source, arguments.frame, source->size());
  }
  const Frame frame = source->read(arguments.frame);
  const auto convention = source->convention();
  fmt::print("source       {}\n", arguments.source);
  fmt::print("frames       {}\n", source->size());
  fmt::print("convention   {}\n", convention ? convention->name : "none (no truth)");
  fmt::print("pixel origin {}\n", source->pixel_origin() == PixelOrigin::centre ? "centre" : "corner");
  print_camera(frame.camera);
  print_frame(frame, arguments.frame);
  if (!arguments.png.empty()) write_png(arguments.png, picture_of(frame));
}

}  // namespace

void add_inspect(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "inspect", "Show what a source holds",
               "knuckle inspect --source synthetic:manifests/demo.toml --frame 3 --png frame.png");
  auto arguments = std::make_shared<InspectArguments>();
  verb.add_option("--source", arguments->source, "KIND:PATH[?first=..&count=..&step=..]")->required();
  verb.add_option("--frame", arguments->frame, "Frame to describe")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb.add_option("--png", arguments->png, "File for a picture of that frame, with the true skeleton");
  verb.callback([arguments] { run_inspect(*arguments); });
}

}  // namespace knuckle::cli
