// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "knuckle/core/camera.h"
#include "knuckle/eval/pictures/drawing.h"
#include "knuckle/hand/flesh_cone.h"

namespace knuckle {

/// What a camera would see of the flesh of hands and of nothing else, in the pixels of a view.
struct SeenSurface {
  Image<float> depth_mm;  ///< 0 where no flesh is seen
  Image<float> facing;    ///< cosine between the skin's normal and the way to the camera, [0, 1]
};

/// One ray per pixel of the view's picture. Throws an Error where the camera is impossible.
SeenSurface seen_surface(std::span<const FleshCone> flesh, const Camera& camera, const View& view);

/// Lays the surface over a picture of the same size: shaded, so that the picture shines through.
void draw_surface(Image<Rgb>& picture, const SeenSurface& surface);

/// Differences beyond this have the colour of its end [mm].
inline constexpr double kDifferenceMm = 20.0;

inline constexpr Rgb kMeasuredBefore{0x00, 0x72, 0xb2};  ///< measured depth lies before the surface: blue
inline constexpr Rgb kAlike{0xf2, 0xf0, 0xe6};           ///< no difference: almost white
inline constexpr Rgb kMeasuredBehind{0xd5, 0x5e, 0x00};  ///< the surface floats before what was measured: red
inline constexpr Rgb kNotMeasured{0x50, 0x4d, 0x58};     ///< nothing was measured where the surface is: grey

/// The colour of measured depth less the surface's [mm].
Rgb difference_colour(double difference_mm);

/// A surface held against the depth image.
struct SurfaceDifference {
  Image<Rgb> picture;      ///< of the view; what is not covered by the surface is the depth, darkened
  double median_mm = 0.0;  ///< of its absolute values over the pixels that are measured; NaN where none is
};

/// Compares pixel by pixel of the depth image; `view` and `range` are those of its picture.
SurfaceDifference surface_difference(std::span<const FleshCone> flesh, const Image<float>& depth_mm,
                                     const Camera& camera, const View& view, const DepthRange& range);

}  // namespace knuckle
