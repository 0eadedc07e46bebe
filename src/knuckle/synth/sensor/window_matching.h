// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/core/image.h"
#include "knuckle/core/options.h"

namespace knuckle {

/// Stereo cameras compare windows, not pixels (Kanade and Okutomi, "A stereo matching algorithm with an
/// adaptive window: theory and experiment", 1994): surfaces become smooth, what is nearer grows at its
/// outline, narrow gaps between fingers close, and thin things vanish.
struct WindowMatchingOptions {
  int window_px = 0;          ///< the window reaches so far on each side, [0, 16] [px]; 0: off
  int widest_window_px = 0;   ///< each frame draws a reach from window_px to this, [0, 16] [px]; 0: window_px
  double window_share = 1.0;  ///< part of the frames that are seen so, [0, 1]
  double nearer_share = 0.4;  ///< the nearer surface wins where it fills more than this part, [0, 1]
  /// Each frame draws that part from nearer_share to this, [0, 1]; 0: nearer_share. The surface with more
  /// texture takes more of a window: above a half, outlines of smooth skin shrink, and finger tips are lost.
  double largest_nearer_share = 0.0;
  /// In such frames range noise is alike over so many reaches, [0, 4]; 0: over grain_px.
  double window_grain = 0.0;

  void visit(OptionVisitor& visitor);
};

/// How far windows reach in the frame of `seed` [px]; 0: it is not seen in windows.
int drawn_window_px(const WindowMatchingOptions& options, std::uint64_t seed);
/// At which part of a window the nearer surface wins in the frame of `seed`, [0, 1].
double drawn_nearer_share(const WindowMatchingOptions& options, std::uint64_t seed);

/// `depth_mm` as windows see it. Disparities, which are proportional to 1 / z, are averaged over the measured
/// pixels of the window that belong to the winning surface; surfaces are more than `jump_mm` apart. Where the
/// nearer one fills nearly the share at which it wins (within 0.06), every other pixel finds no match. What
/// is not measured stays so, where the window holds less than half of measured pixels.
Image<float> matched_in_windows(const Image<float>& depth_mm, const WindowMatchingOptions& options,
                                double jump_mm, std::uint64_t seed);

}  // namespace knuckle
