// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/placement_options.h"

namespace knuckle {

void PlacementOptions::visit(OptionVisitor& visitor) {
  visitor.real("facing_share", facing_share, at_least(0));
  visitor.real("shoulder_share", shoulder_share, at_least(0));
  visitor.real("free_share", free_share, at_least(0));
  visitor.real("above_share", above_share, at_least(0));
  visitor.real("around_share", around_share, at_least(0));
  visitor.real("eyes_share", eyes_share, at_least(0));
  visitor.real("yaw_deg", yaw_deg, closed(0, 180));
  visitor.real("pitch_deg", pitch_deg, closed(0, 90));
  visitor.real("roll_deg", roll_deg, closed(0, 180));
  visitor.real("nearest_mm", nearest_mm, closed(100, 5000));
  visitor.real("farthest_mm", farthest_mm, closed(100, 5000));
  visitor.real("off_centre", off_centre, closed(0, 1));
  visitor.real("border_share", border_share, closed(0, 1));
  visitor.real("trunk_gap_mm", trunk_gap_mm, closed(-1000, 1000));
  visitor.real("forearm_margin_mm", forearm_margin_mm, closed(0, 1000));
  visitor.real("wrist_deg", wrist_deg, closed(0, 90));
  visitor.real("presented_share", presented_share, closed(0, 1));
  visitor.real("palm_deg", palm_deg, open_closed(0, 180));
  visitor.real("upright_deg", upright_deg, open_closed(0, 180));
}

void check(const PlacementOptions& options, std::string_view what) {
  check_options(options, what);
  if (options.facing_share + options.shoulder_share + options.free_share + options.above_share +
          options.around_share + options.eyes_share <=
      0.0) {
    fail(
        "{}: facing_share, shoulder_share, free_share, above_share, around_share and eyes_share are all 0; "
        "expected one above 0",
        what);
  }
  if (options.nearest_mm > options.farthest_mm) {
    fail("{}: nearest_mm is {}, expected at most farthest_mm, {}", what, options.nearest_mm,
         options.farthest_mm);
  }
}

}  // namespace knuckle
