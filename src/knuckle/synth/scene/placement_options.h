// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "knuckle/core/options.h"

namespace knuckle {

/// How a person and a hand stand before the camera. Shares need not sum to 1.
struct PlacementOptions {
  double facing_share = 0.65;    ///< the person faces the camera, at least 0
  double shoulder_share = 0.10;  ///< the camera looks the person's way, from head or shoulder, at least 0
  double free_share = 0.25;      ///< any side up, at least 0
  double above_share = 0.0;      ///< the camera looks down on the person's hands from any side, at least 0
  double around_share = 0.0;     ///< the camera stands anywhere around the person, at least 0
  double eyes_share = 0.0;       ///< the camera is worn at the person's eyes, at least 0
  double yaw_deg = 35.0;         ///< deviation of the person's turn about the upright, [0, 180] [degree]
  double pitch_deg = 20.0;       ///< deviation of the camera's tilt, [0, 90] [degree]
  double roll_deg = 15.0;        ///< deviation of the camera's roll, [0, 180] [degree]
  double nearest_mm = 250.0;     ///< of the palm's centre, [100, 5000] [mm]
  double farthest_mm = 1000.0;   ///< of the palm's centre, [nearest_mm, 5000] [mm]
  double off_centre = 0.2;  ///< deviation of the palm from the image's centre, in parts of its size, [0, 1]
  double border_share = 0.08;  ///< frames that may cut the hand, [0, 1]
  double trunk_gap_mm = 60.0;  ///< what else is in view lies this far behind the palm, [-1000, 1000] [mm]
  double forearm_margin_mm = 30.0;  ///< the forearm may be this much nearer than the hand, [0, 1000] [mm]
  double wrist_deg = 25.0;          ///< deviation of the wrist's flexion, [0, 90] [degree]
  double presented_share = 0.0;     ///< frames whose hand is held up with the palm to the camera, [0, 1]
  double palm_deg = 50.0;  ///< there the palm's normal is at most this far from the line of sight, (0, 180]
  double upright_deg = 70.0;  ///< and the fingers' root at most this far from upright in the image, (0, 180]

  void visit(OptionVisitor& visitor);
};

/// Throws an Error that starts with `what` where a value is out of range, all shares are 0, or the nearest is
/// farther than the farthest.
void check(const PlacementOptions& options, std::string_view what);

}  // namespace knuckle
