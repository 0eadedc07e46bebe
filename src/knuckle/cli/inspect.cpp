// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/eval/metrics/hand_statistics.h"
#include "knuckle/eval/pictures/drawing.h"
#include "knuckle/eval/pictures/panels.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle::cli {
namespace {

constexpr int kPanelHeight = 240;  ///< [px]

struct InspectArguments {
  std::string source;
  std::int64_t frame = 0;
  std::filesystem::path png;
  std::filesystem::path panels;
  bool statistics = false;
  std::filesystem::path pipeline = resource_path("pipelines/default.toml");
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
  fmt::print("frame        {} '{}': {} of {} pixels measured, {:g} to {:g} mm\n", index,
             printable(frame.name), depth.valid_pixels, frame.depth_mm.size(), depth.nearest_mm,
             depth.farthest_mm);
  fmt::print("infrared     {}\n", frame.infrared.empty() ? "no" : "yes");
  fmt::print("mask         {}\n", frame.mask.empty() ? "no" : "yes");
  if (!frame.truth) return;
  const auto known =
      std::ranges::count_if(frame.truth->joints, [](const ImagePoint& p) { return !p.is_missing(); });
  fmt::print("truth        {} of {} joints known\n", known, frame.truth->joints.size());
}

/// The statistics of the hand in each frame; nothing where none is found.
std::vector<std::optional<HandStatistics>> statistics_of(const FrameSource& source,
                                                         const HandFinder& finder) {
  std::vector<std::optional<HandStatistics>> frames(static_cast<std::size_t>(source.size()));
  parallel_for(source.size(), [&](std::int64_t i) {
    const Frame frame = source.read(i);
    const Segmentation segmentation = finder.find(frame, std::nullopt);
    if (segmentation.hands.empty()) return;
    const HandRegion& hand = segmentation.hands.front();
    frames[i] = hand_statistics(frame.depth_mm, hand.box, hand.mask);
  });
  return frames;
}

void print_statistics(const FrameSource& source, const HandFinder& finder) {
  std::vector<HandStatistics> found;
  for (const auto& frame : statistics_of(source, finder)) {
    if (frame) found.push_back(*frame);
  }
  const HandStatistics mean = mean_of(found);
  fmt::print("hands        found in {} of {} frames; means over those:\n", found.size(), source.size());
  fmt::print("  depth         {:8.1f} mm\n", mean.depth_mm);
  fmt::print("  depth spread  {:8.1f} mm\n", mean.depth_spread_mm);
  fmt::print("  valid in box  {:8.1f} %\n", 100.0 * mean.valid_share);
  fmt::print("  surface noise {:8.2f} mm\n", mean.surface_noise_mm);
  fmt::print("  edge noise    {:8.2f} px\n", mean.edge_noise_px);
  fmt::print("  flying pixels {:8.1f} % of those at depth edges\n", 100.0 * mean.flying_share);
}

void run_inspect(const InspectArguments& arguments) {
  const auto source = open_source(arguments.source);
  if (arguments.frame >= source->size()) {
    fail("{}: frame {} was asked for, it has {}", arguments.source, arguments.frame, source->size());
  }
  const Frame frame = source->read(arguments.frame);
  const auto convention = source->convention();
  fmt::print("source       {}\n", printable(arguments.source));
  fmt::print("frames       {}\n", source->size());
  fmt::print("convention   {}\n", convention ? convention->name : "none (no truth)");
  fmt::print("pixel origin {}\n", source->pixel_origin() == PixelOrigin::centre ? "centre" : "corner");
  print_camera(frame.camera);
  print_frame(frame, arguments.frame);
  if (!arguments.png.empty()) write_png(arguments.png, picture_of(frame));
  if (!arguments.panels.empty()) write_png(arguments.panels, panels_of(frame, kPanelHeight));
  if (arguments.statistics) print_statistics(*source, HandFinder::load(arguments.pipeline));
}

}  // namespace

void add_inspect(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "inspect", "Show what a source holds",
               "knuckle inspect --source synthetic:manifests/demo.toml --frame 3 --png frame.png");
  auto arguments = std::make_shared<InspectArguments>();
  add_source_option(verb, arguments->source);
  verb.add_option("--frame", arguments->frame, "Frame to describe; the first is 0")
      ->check(CLI::NonNegativeNumber.description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--png", arguments->png, "Picture of that frame, with the true skeleton")
      ->type_name("FILE");
  verb.add_option("--panels", arguments->panels,
                  "Picture of the hand in that frame's depth, mask and infrared, side by side")
      ->type_name("FILE");
  verb.add_flag(
      "--statistics", arguments->statistics,
      "Measure noise, holes and depth spread of the hand, as segmentation finds it, over all frames");
  verb.add_option("--pipeline", arguments->pipeline,
                  "Pipeline file whose segmentation finds the hand, for --statistics")
      ->type_name("FILE")
      ->capture_default_str();
  verb.callback([arguments] { run_inspect(*arguments); });
}

}  // namespace knuckle::cli
