// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

#include "knuckle/core/frame.h"
#include "knuckle/data/frame_source.h"

namespace knuckle {

/// Where the search for a hand starts in each frame.
enum class Start {
  nearest,  ///< where the method chooses: at the nearest point
  truth,    ///< at the true palm (`true_start`); an error in a source without truth
};

/// The names of the two, for the command line.
inline constexpr std::string_view kStartNames[] = {"nearest", "truth"};
/// Throws an Error where the name is none of the two.
Start start_from_name(std::string_view name);

/// The start in one frame; nothing for `nearest`, and for a frame whose truth knows no joint.
std::optional<Point3> start_in(const Frame& frame, Start start);

/// Throws an Error that names the source where the search was to start at the truth and it has none.
void require_start(const FrameSource& source, Start start, std::string_view source_name);

}  // namespace knuckle
