// SPDX-License-Identifier: Apache-2.0
// The pose of a hand from an array of depths, as a camera driver gives them: 320 x 240 floats [mm] on
// standard input.
#include <cstdio>

#include <knuckle/core/resources.h>
#include <knuckle/pipeline/pipeline.h>

int main() try {
  // The shipped pipeline; a program that brings the files itself says where they are by set_data_folder().
  const auto pipeline = knuckle::Pipeline::load(knuckle::resource_path("pipelines/default.toml"));
  knuckle::Frame frame;
  frame.camera = {.width = 320, .height = 240, .fx = 224.0, .fy = 224.0, .cx = 159.5, .cy = 119.5};
  frame.depth_mm = knuckle::Image<float>(320, 240);
  while (std::fread(frame.depth_mm.data(), sizeof(float), frame.depth_mm.size(), stdin) ==
         frame.depth_mm.size()) {
    for (const knuckle::HandEstimate& hand : pipeline.estimate(frame).hands) {
      for (const knuckle::ImagePoint& joint : hand.pose.joints)
        std::printf("%.2f %.2f %.1f  ", joint.u, joint.v, joint.depth_mm);
    }
    std::puts("");
  }
} catch (const std::exception& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
