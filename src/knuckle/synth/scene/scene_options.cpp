// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/scene/scene_options.h"

#include <algorithm>

#include "knuckle/synth/scene/grasp.h"
#include "knuckle/synth/scene/things.h"

namespace knuckle {

void SceneOptions::visit(OptionVisitor& visitor) {
  visitor.real("empty_share", empty_share, closed(0, 1));
  visitor.real("stump_share", stump_share, closed(0, 1));
  visitor.real("room_share", room_share, closed(0, 1));
  visitor.real("table_share", table_share, closed(0, 1));
  visitor.real("rest_share", rest_share, closed(0, 1));
  visitor.integer("most_things", most_things, closed(0, 30));
  visitor.real("cloth_share", cloth_share, closed(0, 1));
  visitor.real("before_share", before_share, closed(0, 1));
  visitor.real("least_visible", least_visible, closed(0, 1));
  visitor.real("second_share", second_share, closed(0, 1));
  visitor.real("crossed_share", crossed_share, closed(0, 1));
  visitor.real("touching_share", touching_share, closed(0, 1));
  visitor.integer("second_pass_frames", second_pass_frames, closed(0, 10000));
  visitor.real("held_share", held_share, closed(0, 1));
  visitor.texts("grasps", grasps, grasp_names());
  visitor.real("sleeve_share", sleeve_share, closed(0, 1));
  visitor.real("band_share", band_share, closed(0, 1));
  visitor.real("cut_share", cut_share, closed(0, 1));
  visitor.texts("things", things, thing_kinds());
  visitor.texts("without_things", without_things, thing_kinds());
}

bool SceneOptions::is_active() const {
  return empty_share > 0.0 || room_share > 0.0 || table_share > 0.0 || most_things > 0 ||
         before_share > 0.0 || second_share > 0.0 || held_share > 0.0 || sleeve_share > 0.0 ||
         band_share > 0.0 || cut_share > 0.0;
}

std::vector<std::string_view> allowed_things(const SceneOptions& options) {
  const auto holds = [](const std::vector<std::string>& names, std::string_view name) {
    return std::ranges::find(names, name) != names.end();
  };
  std::vector<std::string_view> allowed;
  for (const std::string_view kind : thing_kinds()) {
    const bool is_listed = options.things.empty() || holds(options.things, kind);
    if (is_listed && !holds(options.without_things, kind)) allowed.push_back(kind);
  }
  return allowed;
}

void check(const SceneOptions& options, std::string_view what) {
  check_options(options, what);
  if (options.most_things > 0 && allowed_things(options).empty()) {
    fail("{}: most_things is {}, but things and without_things leave none to draw from", what,
         options.most_things);
  }
  if (options.before_share > 0.0 && options.least_visible >= 1.0) {
    fail("{}: before_share is {}, but least_visible is 1: nothing may be before the hand", what,
         options.before_share);
  }
  if (options.crossed_share + options.touching_share > 1.0) {
    fail("{}: crossed_share and touching_share are {} and {}: together they are more than all second hands",
         what, options.crossed_share, options.touching_share);
  }
  if (options.held_share == 0.0 && !options.grasps.empty()) {
    fail("{}: grasps are named, but held_share is 0: nothing is held", what);
  }
  if (options.empty_share == 0.0 && options.stump_share > 0.0) {
    fail("{}: stump_share is {}, but empty_share is 0: every arm has its hand", what, options.stump_share);
  }
  if (options.empty_share + options.cut_share > 1.0) {
    fail("{}: empty_share and cut_share are {} and {}: together they are more than all frames", what,
         options.empty_share, options.cut_share);
  }
}

}  // namespace knuckle
