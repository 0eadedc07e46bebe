// SPDX-License-Identifier: Apache-2.0
#include "knuckle/segment/detector/detector_options.h"

#include "knuckle/core/error.h"

namespace knuckle {

void DetectorOptions::visit(OptionVisitor& visitor) {
  visitor.integer("width", width, closed(16, 1024));
  visitor.integer("height", height, closed(16, 1024));
  visitor.real("focal_cells", focal_cells, closed(8, 2000));
  visitor.integer("stem_channels", stem_channels, closed(1, 1024));
  visitor.integer("quarter_channels", quarter_channels, closed(1, 1024));
  visitor.integer("eighth_channels", eighth_channels, closed(1, 1024));
  visitor.integer("sixteenth_channels", sixteenth_channels, closed(1, 1024));
  visitor.integer("head_channels", head_channels, closed(1, 1024));
  visitor.integer("blocks", blocks, closed(1, 16));
  visitor.flag("relief", relief);
  visitor.real("side_weight", side_weight, closed(0, 100));
}

EncoderDecoderShape DetectorOptions::shape() const {
  return {.inputs = inputs(),
          .stem = stem_channels,
          .quarter = quarter_channels,
          .eighth = eighth_channels,
          .sixteenth = sixteenth_channels,
          .head = head_channels,
          .blocks = blocks,
          .maps = kDetectorMaps};
}

void check(const DetectorOptions& options, std::string_view what) {
  check_options(options, what);
  if (options.width % kCoarsestStride != 0 || options.height % kCoarsestStride != 0) {
    fail("{}: the detector's picture has {} x {} cells, expected multiples of {}", what, options.width,
         options.height, kCoarsestStride);
  }
}

}  // namespace knuckle
