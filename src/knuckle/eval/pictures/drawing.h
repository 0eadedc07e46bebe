// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/box.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"
#include "knuckle/core/rgb.h"

namespace knuckle {

/// Depths that a picture tells apart [mm].
struct DepthRange {
  double near_mm = 0.0;
  double far_mm = 1.0;
};

inline constexpr Rgb kTruthColour{0x1f, 0xe0, 0xff};     ///< of true skeletons: cyan
inline constexpr Rgb kEstimateColour{0xff, 0x8c, 0x1a};  ///< of estimated ones: orange

inline constexpr Rgb kSheetColour{0x2a, 0x27, 0x30};  ///< what pictures are laid on

/// Depth as colours: near is bright, far is dark, what lies outside the range takes the colour of its end,
/// and a pixel without measurement is almost black.
Image<Rgb> colour_mapped(const Image<float>& depth_mm, const DepthRange& range);

/// The range from the 1st to the 99th percentile of the measured depths in `crop`; [0, 1] where there are
/// none.
DepthRange depth_range_in(const Image<float>& depth_mm, const Box& crop);

/// A part of the image plane that is shown enlarged (or shrunk). It may reach over the image's border.
struct View {
  Box crop;            ///< [px of the image], not empty
  double scale = 1.0;  ///< picture pixels per pixel of the image, above 0

  int width() const { return std::max(1, static_cast<int>(std::lround(crop.width * scale))); }
  int height() const { return std::max(1, static_cast<int>(std::lround(crop.height * scale))); }
};

/// The part of a depth image that `view` shows, colour-mapped, enlarged without smoothing. Ground beyond the
/// border (or all of it, where the image is empty) is the colour of no measurement.
Image<Rgb> picture_of(const Image<float>& depth_mm, const View& view, const DepthRange& range);

/// Draws the bones and joints of a pose (skeleton_of its convention) over a picture of `view`, anti-aliased,
/// with a dark rim that keeps them apart from bright ground. Missing joints and their bones are left out.
void draw_skeleton(Image<Rgb>& picture, const HandPose& pose, const View& view, const Rgb& colour);

/// Draws the outline of a part of the image over a picture of `view`.
void draw_box(Image<Rgb>& picture, const Box& box, const View& view, const Rgb& colour);

/// Writes small light letters with a dark rim, their lower left corner at (x, y) [px of the picture]. ASCII
/// only.
void draw_text(Image<Rgb>& picture, std::string_view text, int x, int y);

/// The colour `share` of the way from one to the other, in [0, 1].
Rgb mixed(const Rgb& from, const Rgb& to, double share);

/// A part of a picture, which may reach over its border: ground there is the colour of no measurement.
Image<Rgb> cropped(const Image<Rgb>& picture, const Box& crop);

/// The picture at another size, at least 1 x 1: smoothed where it shrinks.
Image<Rgb> resized(const Image<Rgb>& picture, int width, int height);

/// Lays a picture on a sheet, its upper left corner at (x, y); it has to be within the sheet.
void paste(const Image<Rgb>& picture, Image<Rgb>& sheet, int x, int y);

/// The whole frame as a picture for people, with its true skeleton where it has one; small images are
/// enlarged.
Image<Rgb> picture_of(const Frame& frame);

/// "#rrggbb".
std::string hex_code(const Rgb& colour);

}  // namespace knuckle
