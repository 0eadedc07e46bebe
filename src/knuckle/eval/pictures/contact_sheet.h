// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/data/frame_source.h"
#include "knuckle/data/readers/image_io.h"

namespace knuckle {

/// How a contact sheet is laid out.
struct ContactSheetOptions {
  int columns = 6;          ///< [1, 100]
  int tile_width_px = 200;  ///< width of a whole frame's picture, [32, 2000]

  void visit(OptionVisitor& visitor);
};

/// `tiles` frames spread evenly over [first, first + count), its ends included; all of them where they are
/// fewer. Throws an Error where one of the numbers is impossible.
std::vector<std::int64_t> spread_frames(std::int64_t first, std::int64_t count, int tiles);

/// Small pictures of these frames in rows: the whole frame with its index, near depth is bright, the hand's
/// mask tinted; and beside it the hand from near with its true skeleton. Frames are read on all threads.
/// Throws an Error where there is no frame.
Image<Rgb> contact_sheet(const FrameSource& source, const std::vector<std::int64_t>& frames,
                         const ContactSheetOptions& options = {});

}  // namespace knuckle
