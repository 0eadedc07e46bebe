// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"

namespace knuckle {

/// What surrounds the hand: the `[scene]` table of a manifest. Shares are parts of the frames (of a smooth
/// motion: of its sequences), each drawn for itself. By default there is nothing but the person.
struct SceneOptions {
  double empty_share = 0.0;     ///< rooms without any hand, [0, 1]; not with a smooth motion
  double stump_share = 0.0;     ///< of those: an arm is there that ends without a hand, [0, 1]
  double room_share = 0.0;      ///< floor, walls and ceiling around all, [0, 1]
  double table_share = 0.0;     ///< a table below the hand, [0, 1]
  double rest_share = 0.4;      ///< of the tables: the hand lies on it, [0, 1]
  int most_things = 0;          ///< things on the table, or standing about, at most, [0, 30]
  double cloth_share = 0.2;     ///< of the tables with things: one of them is a cloth, [0, 1]
  double before_share = 0.0;    ///< something that reaches before a part of the hand, [0, 1]
  double least_visible = 0.4;   ///< what hides more than the rest of the hand's pixels is taken away, [0, 1]
  double second_share = 0.0;    ///< the person's other hand is there, too, [0, 1]
  double crossed_share = 0.25;  ///< of the second hands: before or behind the first, [0, 1]
  double touching_share =
      0.25;  ///< of the second hands: they touch; in a smooth motion only where they pass, [0, 1]
  int second_pass_frames = 0;  ///< smooth: it goes past the first and back in so many; 0: stands still
  double held_share = 0.0;     ///< the hand holds something, [0, 1]
  std::vector<std::string> grasps = {};  ///< how it is held; empty: in any way
  double sleeve_share = 0.0;             ///< a sleeve on the arm, [0, 1]
  double band_share = 0.0;               ///< a watch or band about the wrist, [0, 1]
  double cut_share = 0.0;  ///< a hand cut off near the wrist before nothing, as in crops, [0, 1]
  std::vector<std::string> things = {};          ///< kinds of things that are drawn; empty: all
  std::vector<std::string> without_things = {};  ///< kinds that are left out of those

  void visit(OptionVisitor& visitor);

  /// Whether any frame has more than one person's body before nothing.
  bool is_active() const;
};

/// The kinds of things that the options leave to draw from.
std::vector<std::string_view> allowed_things(const SceneOptions& options);

/// An option that contradicts another one.
struct SceneFault {
  std::string key;
  std::string message;
};

/// Throws an Error that starts with `what` where a value is out of range, or contradicts another one.
void check(const SceneOptions& options, std::string_view what);

}  // namespace knuckle
