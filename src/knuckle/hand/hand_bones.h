// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

#include <Eigen/Core>

#include "knuckle/hand/hand_angles.h"

namespace knuckle {

/// The rigid parts of a hand, parents before children. The metacarpals of index and middle finger do not move
/// against the carpus: they are the palm.
enum class HandBone : std::uint8_t {
  palm,
  ring_metacarpal,
  little_metacarpal,
  thumb_metacarpal,
  thumb_proximal,
  thumb_distal,
  index_proximal,
  index_middle,
  index_distal,
  middle_proximal,
  middle_middle,
  middle_distal,
  ring_proximal,
  ring_middle,
  ring_distal,
  little_proximal,
  little_middle,
  little_distal,
};

/// Number of bones of a hand.
inline constexpr int kHandBoneCount = 18;

/// The bone's name, for example "index_middle".
std::string_view name_of(HandBone bone);

/// The bones of a digit (0 thumb to 4 little): `joint` 0 to 2 from the palm outwards.
HandBone bone_of_digit(int digit, int joint);

/// One hinge of a joint: it turns by `share` times an angle of the hand about an axis, right-handed. What is
/// coupled has several hinges with one angle: the ring metacarpal follows the little finger's by half.
struct BoneTurn {
  HandAngle angle = HandAngle::palm_arch;
  double share = 1.0;                               ///< not 0
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< of length 1
};

}  // namespace knuckle
