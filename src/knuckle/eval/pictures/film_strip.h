// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/options.h"
#include "knuckle/eval/pictures/gallery.h"

namespace knuckle {

/// How a film strip is laid out.
struct FilmStripOptions {
  int columns = 10;           ///< frames in a row, [1, 100]; more where the strip would be too high
  int picture_size_px = 150;  ///< of a picture's side, [64, 2000]
  int most_frames = 1000;     ///< more are left out evenly, [1, 1000]

  void visit(OptionVisitor& visitor);
};

/// All frames of a sequence in one picture, in rows: the pictures of a gallery, those of a frame
/// one below the other, with the frame's number and the method's error. Throws an Error where there is no
/// frame, an option is out of range, or the strip would be wider or higher than an image may be.
Image<Rgb> film_strip(const GalleryInput& input, const FilmStripOptions& options = {});

}  // namespace knuckle
