// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "knuckle/core/random.h"
#include "knuckle/hand/skinning.h"
#include "knuckle/synth/makehuman/hand_anatomy.h"

namespace knuckle {

/// How the bones of one right hand differ from those that the body's shape gives it: factors, 1 leaves a bone
/// as it is. This is the paper's "size of the hand and the fingers" (Riegler et al. 2015, sec. 4).
struct HandProportions {
  double palm_length = 1.0;                                 ///< from the wrist to the MCPs
  double palm_breadth = 1.0;                                ///< of palm and knuckles
  std::array<double, kFingers> ray_lengths{1, 1, 1, 1, 1};  ///< of each metacarpal, beside palm_length
  /// Of the three bones of thumb (metacarpal first) to little finger, from the palm outwards.
  std::array<std::array<double, 3>, kFingers> bone_lengths{
      {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
  std::array<double, kFingers> thicknesses{1, 1, 1, 1, 1};  ///< of each digit
};

/// Random proportions. Each factor is normal about 1, at most two and a half deviations away: a bone of a
/// digit by `deviation`, all bones of a digit together and the palm by 0.7 of it, a metacarpal and a digit's
/// thickness by half of it. Adults of one sex differ by 4 to 8 parts in a hundred in each bone (Garn et al.,
/// "Metacarpophalangeal length in the evaluation of skeletal malformation", 1972), of which hand length
/// explains the larger half.
HandProportions sampled_proportions(double deviation, Random& random);

/// The person with these proportions: every bone of the hand is stretched along itself and across, carries
/// what follows it, and the skin follows its bones by the weights of skinning. Joints and landmarks are read
/// off the new skin. Throws an Error where the body lacks a bone of the hand.
ShapedBody with_proportions(ShapedBody person, const HandProportions& proportions);

/// Breadth of the right hand at rest [mm] as anthropometry measures it: across the knuckles, from the skin
/// beside the index finger's to that beside the little finger's.
double hand_breadth_mm(const ShapedBody& person);

}  // namespace knuckle
