// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_bones.h"

#include <array>

namespace knuckle {

std::string_view name_of(HandBone bone) {
  static constexpr std::array<std::string_view, kHandBoneCount> kNames = {
      "palm",           "ring_metacarpal", "little_metacarpal", "thumb_metacarpal",
      "thumb_proximal", "thumb_distal",    "index_proximal",    "index_middle",
      "index_distal",   "middle_proximal", "middle_middle",     "middle_distal",
      "ring_proximal",  "ring_middle",     "ring_distal",       "little_proximal",
      "little_middle",  "little_distal"};
  return kNames[static_cast<std::size_t>(bone)];
}

HandBone bone_of_digit(int digit, int joint) {
  constexpr int kBonesPerDigit = 3;
  return static_cast<HandBone>(static_cast<int>(HandBone::thumb_metacarpal) + kBonesPerDigit * digit + joint);
}

}  // namespace knuckle
