// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/motion_options.h"

#include <array>

namespace knuckle {
namespace {

constexpr std::array<std::string_view, 2> kMotions = {"none", "smooth"};

}  // namespace

void MotionOptions::visit(OptionVisitor& visitor) {
  visitor.choice("motion", motion, kMotions);
  visitor.integer("frames_a_pose", frames_a_pose, closed(1, 10000));
  visitor.integer("sequence_frames", sequence_frames, closed(0, 100000000));
  visitor.real("sway_deg", sway_deg, closed(0, 90));
}

}  // namespace knuckle
