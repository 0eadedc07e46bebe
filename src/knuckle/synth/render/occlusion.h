// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/core/pose.h"
#include "knuckle/synth/render/rasteriser.h"

namespace knuckle {

/// A rendering of everything that has one label.
struct LabelledRendering {
  PixelLabel label = PixelLabel::object;
  const Rendering* rendering = nullptr;
};

/// How far a landmark lies below the skin at most, from any side [mm]: in parts of the distance from the
/// wrist to the middle finger's MCP. What is farther before it is another part of the hand.
double flesh_mm(Landmark landmark, const std::array<Point3, kSupersetSize>& landmarks);

/// What lies before each of a hand's landmarks, at the pixel that holds it. `hand` shows that hand alone;
/// `others` all the rest.
std::vector<Occluder> occluders_of(const std::array<Point3, kSupersetSize>& landmarks, const HandPose& pose,
                                   const Rendering& hand, std::span<const LabelledRendering> others);

}  // namespace knuckle
