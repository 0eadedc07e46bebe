// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "knuckle/core/options.h"
#include "knuckle/core/random.h"
#include "knuckle/prepare/detector_samples.h"

namespace knuckle {

/// Random views of a detector's samples, and what may be wrong with them: the `[augmentation]` table.
struct DetectorAugmentation {
  double mirrored_share = 0.5;  ///< views in a mirror, sides exchanged, [0, 1]
  double zoom = 0.25;           ///< nearer or farther by up to this part, [0, 0.9]
  double shift_cells = 24.0;    ///< along each axis, uniform in +-, [0, 512] [cells]
  double rotation_deg = 20.0;   ///< in the image plane, uniform in +-, [0, 180] [degree]
  double noise_per_m = 0.003;   ///< largest deviation of inverse depth, 3 mm at 1 m, [0, 1] [1/m]
  double missing_share = 0.1;   ///< largest share of single cells that are lost, [0, 0.9]
  int erased_discs = 3;         ///< discs that are not seen at most, [0, 100]
  double erased_cells = 6.0;    ///< largest radius of a disc, [0, 512] [cells]
  double cut_share = 0.15;      ///< views in which all beyond some depth is lost, [0, 1]

  void visit(OptionVisitor& visitor);
};

/// How a view lies in a sample's picture, and whether in a mirror: a point p of the picture is seen at
/// zoom * R(rotation) * (p - middle) + middle + shift, u mirrored after that.
struct PictureView {
  bool is_mirrored = false;
  double zoom = 1.0;  ///< what is 1 m away then is 1 / zoom m away
  double rotation = 0.0;
  double shift_u = 0.0;  ///< [cells]
  double shift_v = 0.0;
};

/// Draws a view.
PictureView random_view(const DetectorAugmentation& augmentation, Random& random);

/// Writes what the network sees, 2 x height x width: inverse depths, then measured shares. Each cell is the
/// nearest one of the sample; nothing was measured outside of it.
void view_cells(const DetectorSample& sample, const DetectorOptions& options, const PictureView& view,
                std::span<float> input);

/// Writes the hands as that view shows them. One whose centre is outside does not count.
void view_hands(const DetectorSample& sample, const DetectorOptions& options, const PictureView& view,
                std::span<float> hands);

/// Spoils an input of `view_cells`: noise, lost cells, discs, and far surfaces.
void spoil_cells(const DetectorAugmentation& augmentation, const DetectorOptions& options, Random& random,
                 std::span<float> input);

/// A hand of which too little is measured in the input need not be found: it no longer counts.
void excuse_unseen_hands(const DetectorOptions& options, std::span<const float> input,
                         std::span<float> hands);

}  // namespace knuckle
