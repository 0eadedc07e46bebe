// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/text.h"
#include "knuckle/stream/camera_check.h"
#include "knuckle/stream/open_camera.h"

namespace knuckle::cli {
namespace {

void print_listing(const CameraListing& camera) {
  fmt::print("{:<24} {:<32} {}\n", printable(camera.stream), printable(camera.device),
             printable(camera.state));
}

/// What is connected, and what this build could not find.
void list_cameras() {
  bool is_any = false;
  for (const CameraKind& kind : camera_kinds()) {
    if (!kind.is_built) continue;
    for (const CameraListing& camera : kind.list()) {
      print_listing(camera);
      is_any = is_any || camera.is_usable;
    }
  }
  if (!is_any) fmt::print("no depth camera is connected, or none that this user may see (docs/cameras.md)\n");
  for (const CameraKind& kind : camera_kinds()) {
    if (!kind.is_built) fmt::print("{}: not in this build, which lacks the library\n", kind.name);
  }
}

void print_check(const CameraCheck& check, const CameraFacts& facts) {
  fmt::print("device       {}\n", facts.device.empty() ? "without a name" : printable(facts.device));
  fmt::print("format       {}\n", printable(facts.format));
  fmt::print("intrinsics   {}\n", facts.intrinsics.empty() ? "not known" : printable(facts.intrinsics));
  fmt::print("frames       {}, {} x {} px, {:.1f} per second, {} lost on the way\n", check.frames,
             check.width, check.height, check.rate_hz, check.lost);
  fmt::print("infrared     {}\n", check.has_infrared ? "yes" : "no");
  fmt::print("measured     {:.1f} % of the pixels\n", 100.0 * check.measured_share);
  if (check.median_mm) {
    fmt::print("depth        {:.4g} to {:.4g} mm (98 of 100 pixels), median {:.4g} mm\n", *check.nearest_mm,
               *check.farthest_mm, *check.median_mm);
  }
  if (check.noise_mm) {
    fmt::print("noise        {:.2g} mm from frame to frame, if nothing moved\n", *check.noise_mm);
  }
}

void check_stream(const std::string& stream, int frames) {
  const auto camera = open_camera(stream, UnknownIntrinsics::guess);
  const CameraCheck check = check_camera(*camera, {.most_frames = frames});
  print_check(check, camera->facts());
  std::fflush(stdout);
  for (const std::string& remark : remarks_on(check, camera->facts()))
    fmt::print(stderr, "warning: {}\n", remark);
}

}  // namespace

void add_cameras(CLI::App& program) {
  CLI::App& verb = add_verb(program, "cameras", "List the cameras that are connected, or look at one of them",
                            "knuckle cameras");
  auto stream = std::make_shared<std::string>();
  verb.add_option(
          "--check", *stream,
          "Takes frames of this camera for some seconds, and says how good they are and what is wrong")
      ->type_name("STREAM");
  auto frames = std::make_shared<int>(CheckLimits().most_frames);
  verb.add_option("--frames", *frames, "Frames that --check takes, in 5 seconds at most")
      ->type_name("N")
      ->check(CLI::Range(2, 10000).description(""))
      ->capture_default_str();
  verb.callback([stream, frames] { stream->empty() ? list_cameras() : check_stream(*stream, *frames); });
}

}  // namespace knuckle::cli
