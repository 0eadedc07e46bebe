// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "knuckle/hand/body.h"

namespace knuckle {

inline constexpr int kFingers = 5;  ///< digits of a hand, the thumb first

/// One hand of a body whose bones have MakeHuman's names.
struct HandOfBody {
  std::string_view suffix;                     ///< ".R" or ".L"
  std::array<VertexGroup, 5> fingertip_bones;  ///< where the last bone of thumb, index, ..., little ends
};

/// MakeHuman's name of a digit's bone: finger 0 (thumb) to 4, joint 0 to 2 from the palm outwards.
std::string finger_bone(int finger, int joint, std::string_view suffix);

/// Moves the finger joints of a hand to where they are in people, and gives its skin weights that fit.
///
/// MakeHuman's skeleton bends the fingers at the web and has proximal phalanges a fifth to a third too short
/// (33.8 mm of a middle finger where anatomy has 49). Here the distances between the centres of rotation are
/// fractions of hand length after Buchholz, Armstrong and Goldstein ("Anthropometric data for describing the
/// kinematics of the human hand", Ergonomics 35, 1992). The joints stay on MakeHuman's line of bones through
/// the finger, as weighted means of its joints, so they follow every morph. `coefficients` is the person on
/// which lengths are measured.
void fit_hand_to_anatomy(Body& body, const HandOfBody& hand, std::span<const double> coefficients);

/// Sets the 22 landmarks from the right hand's joints: joints are bone heads; a finger tip lies a tenth of
/// the last bone inside its end, which is just under the skin's most distal point; the wrist is the head of
/// wrist.R, at the wrist's crease; the palm's centre is half-way between the wrist and the mean of the four
/// finger MCPs.
void set_hand_landmarks(Body& body, const HandOfBody& hand);

}  // namespace knuckle
