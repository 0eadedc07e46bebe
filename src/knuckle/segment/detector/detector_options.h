// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "knuckle/core/options.h"
#include "knuckle/net/layers/encoder_decoder_shape.h"

namespace knuckle {

inline constexpr int kMeasuredInputs = 2;  ///< inverse depth, and how much of the cell was measured
inline constexpr int kReliefInputs = 2;    ///< how far a cell stands out from what is near, and farther about

/// What a detector's network sees, and its channels: all that is needed to build it. Kept in its file.
struct DetectorOptions {
  int width = 128;  ///< of the small picture; a multiple of 16, [16, 1024] [cells]
  int height = 96;  ///< the same, [16, 1024] [cells]
  double focal_cells =
      86.0;                ///< the small picture's focal length, [8, 2000] [cells]; the same for all cameras
  int stem_channels = 16;  ///< [1, 1024]
  int quarter_channels = 32;    ///< [1, 1024]
  int eighth_channels = 48;     ///< [1, 1024]
  int sixteenth_channels = 96;  ///< [1, 1024]
  int head_channels = 32;       ///< before the maps, [1, 1024]
  int blocks = 1;               ///< residual blocks per stage, [1, 16]
  bool relief = false;          ///< it is shown how far each cell stands out, too (`write_reliefs`)
  double side_weight = 0.5;     ///< of the cross entropy of the side in its training, [0, 100]

  void visit(OptionVisitor& visitor);
  EncoderDecoderShape shape() const;
  int inputs() const { return kMeasuredInputs + (relief ? kReliefInputs : 0); }
  int map_width() const { return width / kMapStride; }
  int map_height() const { return height / kMapStride; }
};

/// Throws an Error that starts with `what` where an option is out of range or a size not a multiple of 16.
void check(const DetectorOptions& options, std::string_view what);

// Channels of the maps that come out. All are of the hand whose centre lies in (or near) the cell.
inline constexpr int kHeatMap = 0;     ///< logit: is there a hand's centre?
inline constexpr int kOffsetUMap = 1;  ///< from the cell's centre to the hand's [cells of the maps]
inline constexpr int kOffsetVMap = 2;  ///< the same down the picture
inline constexpr int kInverseDepthMap =
    3;                                ///< logarithm of the centre's inverse depth [1/m], as the view has it
inline constexpr int kExtentMap = 4;  ///< logarithm of the hand's extent over kExtentUnitMm
inline constexpr int kSideMap = 5;    ///< logit: is it a right hand?
inline constexpr int kDetectorMaps = 6;  ///< how many there are

/// The extent whose logarithm is 0 [mm].
inline constexpr double kExtentUnitMm = 100.0;

}  // namespace knuckle
