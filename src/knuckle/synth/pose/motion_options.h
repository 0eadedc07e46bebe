// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "knuckle/core/options.h"

namespace knuckle {

/// How one frame follows another.
struct MotionOptions {
  std::string motion = "none";  ///< none: every frame is another scene; smooth: one person moves
  int frames_a_pose = 12;       ///< smooth: frames from one pose to the next, [1, 10000]
  int sequence_frames = 0;      ///< smooth: frames of each sequence; 0: all are one, [0, 100000000]
  double sway_deg = 8.0;  ///< smooth: deviation of the arm's joints from their first pose, [0, 90] [degree]

  void visit(OptionVisitor& visitor);
  bool is_smooth() const { return motion == "smooth"; }
};

}  // namespace knuckle
