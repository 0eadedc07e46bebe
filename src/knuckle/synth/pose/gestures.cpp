// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/gestures.h"

#include <string>
#include <vector>

#include "knuckle/core/angle.h"
#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr double kCoupled = 1000.0;  ///< a DIP that follows its PIP

/// In degrees, as HandAngle names them.
struct Thumb {
  double radial;
  double palmar;
  double mcp;
  double ip;
  double twist = 0.0;
};
struct Finger {
  double mcp;
  double spread;
  double pip;
  double dip = kCoupled;
};
struct Row {
  std::string_view name;
  Thumb thumb;
  Finger index;
  Finger middle;
  Finger ring;
  Finger little;
  double palm_arch = 0.0;
};

// Fingers that many gestures share.
constexpr Finger kStraight = {2, 0, 4};
constexpr Finger kFist = {80, 0, 96, 58};
constexpr Thumb kThumbOverFist = {30, 57, 27, 66};
constexpr Thumb kThumbBesideFist = {26, 8, 14, 8};
constexpr Thumb kThumbOnPalm = {8, 38, 45, 50, 10};
constexpr Thumb kThumbOut = {55, 5, 0, 0};

constexpr Row kRows[] = {
    // Open hands.
    {"open", {50, 12, 0, 0}, {0, 12, 2}, {0, 0, 2}, {0, 9, 2}, {0, 22, 2}},
    {"spread", {60, 10, -5, -10}, {-8, 20, 0}, {-8, 0, 0}, {-8, 14, 0}, {-10, 30, 0}},
    {"flat", {25, 2, 6, 5}, {2, -3, 3}, {2, 0, 3}, {2, -3, 3}, {2, -4, 3}},
    {"relaxed", {38, 22, 12, 18}, {25, 4, 32}, {32, 0, 38}, {38, 2, 40}, {40, 6, 38}, 4},
    {"resting", {32, 25, 15, 25}, {38, 2, 45}, {45, 0, 52}, {50, 0, 55}, {52, 3, 50}, 6},
    {"flat_thumb_in", kThumbOnPalm, {0, 0, 3}, {0, 0, 3}, {0, 0, 3}, {0, 3, 3}},
    {"bent_flat", {25, 15, 10, 10}, {60, 0, 5}, {62, 0, 5}, {62, 0, 5}, {62, 0, 5}},
    {"cup", {35, 45, 15, 15}, {38, 2, 25}, {40, 0, 28}, {42, 0, 28}, {44, 2, 28}, 15},
    // Closed hands.
    {"fist", kThumbOverFist, kFist, kFist, kFist, kFist, 6},
    {"fist_thumb_beside", kThumbBesideFist, kFist, kFist, kFist, kFist, 6},
    {"loose_fist", {28, 45, 15, 43}, {62, 0, 85}, {66, 0, 88}, {68, 0, 88}, {70, 0, 85}, 6},
    {"thumb_up", {50, -5, -5, -12}, kFist, kFist, kFist, kFist, 6},
    {"hook", {30, 15, 10, 20}, {5, 0, 92}, {5, 0, 95}, {5, 0, 95}, {5, 0, 92}},
    {"claw", {50, 30, 15, 40}, {-8, 12, 62}, {-8, 0, 65}, {-8, 10, 65}, {-8, 20, 62}},
    // Counting and pointing.
    {"point", kThumbOverFist, kStraight, kFist, kFist, kFist, 6},
    {"point_thumb_beside", kThumbBesideFist, kStraight, kFist, kFist, kFist, 6},
    {"gun", kThumbOut, kStraight, kFist, kFist, kFist, 6},
    {"peace", {14, 52, 27, 75, -10}, {0, 15, 3}, {0, -9, 3}, kFist, kFist, 6},
    {"two_thumb", kThumbOut, {0, 14, 3}, {0, -8, 3}, kFist, kFist, 6},
    {"two_together", {14, 52, 27, 75, -10}, {0, -2, 3}, {0, 2, 3}, kFist, kFist, 6},
    {"three", {8, 50, 35, 70, -10}, {0, 14, 3}, {0, 0, 3}, {0, 10, 4}, {75, 0, 92}},
    {"three_thumb", {55, 12, 0, 0}, {0, 10, 3}, {0, -4, 3}, kFist, kFist, 6},
    {"four", kThumbOnPalm, {0, 12, 3}, {0, 0, 3}, {0, 8, 3}, {0, 20, 3}},
    {"little_up", kThumbOverFist, kFist, kFist, kFist, {0, 8, 4}},
    {"middle_up", kThumbOverFist, kFist, {0, 0, 3}, kFist, kFist, 6},
    {"rock", {36, 50, 36, 60, -17}, {0, 5, 3}, kFist, kFist, {0, 10, 4}, 4},
    {"love_you", kThumbOut, {0, 8, 3}, kFist, kFist, {0, 14, 4}, 4},
    {"call_me", {60, 5, -5, -10}, kFist, kFist, kFist, {-5, 20, 3}, 4},
    // Counting on with one hand: the thumb on one finger after another (American), and on all (Chinese
    // seven).
    {"six_thumb_little", {2, 68, 19, 46, -3}, {0, 12, 3}, {0, 0, 3}, {0, 8, 3}, {47, 0, 56}, 18},
    {"seven_thumb_ring", {9, 69, 20, 35, 8}, {0, 12, 3}, {0, 0, 3}, {55, 0, 61}, {0, 20, 3}, 12},
    {"eight_thumb_middle", {23, 60, 20, 34, 12}, {0, 12, 3}, {54, 0, 58}, {0, 8, 3}, {0, 20, 3}},
    {"purse", {30, 66, 34, 31, -13}, {70, 0, 48}, {56, 0, 52}, {51, 0, 46}, {45, 0, 36}, 15},
    // Pinches and grasps (after Feix et al., "The GRASP taxonomy of human grasp types", 2016).
    {"ok", {28, 48, 12, 28, 4}, {51, 0, 57, 31}, {18, 2, 18}, {8, 6, 12}, {2, 16, 8}},
    {"pinch", {30, 48, 15, 30, 4}, {50, 0, 55, 30}, {55, 0, 65}, {62, 0, 72}, {65, 0, 75}, 4},
    {"pinch_open", {35, 45, 5, 10}, {32, 2, 32, 15}, {45, 0, 55}, {55, 0, 65}, {60, 0, 68}, 4},
    {"tripod", {27, 55, 13, 31, -8}, {60, -2, 52, 36}, {60, 2, 53, 45}, {65, 0, 80}, {68, 0, 82}, 6},
    {"quadpod", {16, 55, 20, 28, 7}, {66, 0, 38, 42}, {54, 0, 47, 34}, {45, 0, 58, 40}, {68, 0, 78}, 8},
    {"lateral_pinch", {27, 20, 20, 6}, {45, 0, 75}, {60, 0, 85}, {65, 0, 88}, {68, 0, 88}, 5},
    {"cylinder", {30, 58, 12, 25}, {40, 2, 45}, {45, 0, 48}, {48, 0, 50}, {50, 2, 48}, 8},
    {"small_cylinder", {20, 50, 8, 32, 12}, {58, 0, 72}, {62, 0, 75}, {64, 0, 75}, {66, 0, 72}, 8},
    {"sphere", {42, 55, 8, 20}, {30, 12, 38}, {32, 0, 40}, {34, 8, 40}, {36, 18, 40}, 12},
    {"disk", {45, 42, 8, 25}, {12, 16, 42}, {12, 0, 45}, {12, 12, 45}, {12, 24, 42}, 6},
    {"writing", {26, 46, 25, 20, 5}, {55, 0, 42, 12}, {60, 0, 58, 30}, {65, 0, 75}, {66, 0, 76}, 6},
    {"extended_grip", {25, 60, 8, 5}, {58, 0, 10, 5}, {60, 0, 10, 5}, {60, 0, 10, 5}, {60, 0, 10, 5}, 6},
    {"index_extension", {30, 54, 12, 25}, {22, 0, 12, 6}, {52, 0, 58}, {56, 0, 60}, {58, 0, 58}, 8},
    {"adduction_grip", {42, 8, 1, 5}, {8, -6, 15}, {16, 3, 20}, {30, 2, 36}, {32, 4, 35}},
    {"light_tool", {27, 30, 20, 24}, {66, 0, 84}, {70, 0, 88}, {72, 0, 88}, {74, 0, 85}, 7},
    // Letters of the American finger alphabet that no gesture above shows.
    {"letter_c", {38, 55, 8, 22}, {28, 0, 42}, {28, 0, 44}, {28, 0, 44}, {28, 0, 42}, 4},
    {"letter_d", {20, 60, 16, 33}, {0, 2, 3}, {57, 0, 61}, {61, 0, 66}, {64, 0, 68}, 6},
    {"letter_e",
     {15, 53, 20, 42, 15},
     {38, 0, 105, 65},
     {40, 0, 105, 65},
     {42, 0, 105, 65},
     {42, 0, 102, 62}},
    {"letter_k", {24, 44, 8, 6}, {0, 10, 3}, {44, -4, 6}, kFist, kFist, 6},
    {"letter_l", {62, 0, 0, -5}, kStraight, kFist, kFist, kFist, 6},
    {"letter_o", {28, 54, 15, 28, 5}, {50, 0, 52, 28}, {54, 0, 50, 30}, {56, 0, 50, 30}, {58, 0, 48, 30}, 8},
    {"letter_x", kThumbOverFist, {15, 0, 80, 45}, kFist, kFist, kFist, 6},
};

void set_finger(HandAngles& angles, int finger, const Finger& degrees) {
  const FingerAngleNames names = angles_of_finger(finger);
  angles[names.mcp] = degrees.mcp * kDegree;
  angles[names.spread] = degrees.spread * kDegree;
  angles[names.pip] = degrees.pip * kDegree;
  angles[names.dip] = degrees.dip == kCoupled ? coupled_dip(degrees.pip * kDegree) : degrees.dip * kDegree;
}

Gesture gesture_of(const Row& row) {
  HandAngles angles;
  angles[HandAngle::thumb_radial] = row.thumb.radial * kDegree;
  angles[HandAngle::thumb_palmar] = row.thumb.palmar * kDegree;
  angles[HandAngle::thumb_twist] = row.thumb.twist * kDegree;
  angles[HandAngle::thumb_mcp] = row.thumb.mcp * kDegree;
  angles[HandAngle::thumb_ip] = row.thumb.ip * kDegree;
  set_finger(angles, 0, row.index);
  set_finger(angles, 1, row.middle);
  set_finger(angles, 2, row.ring);
  set_finger(angles, 3, row.little);
  angles[HandAngle::palm_arch] = row.palm_arch * kDegree;
  return {row.name, angles};
}

}  // namespace

std::span<const Gesture> gestures() {
  static const std::vector<Gesture> all_gestures = [] {
    std::vector<Gesture> all;
    for (const Row& row : kRows) all.push_back(gesture_of(row));
    return all;
  }();
  return all_gestures;
}

const Gesture& gesture_from_name(std::string_view name) {
  std::vector<std::string> known;
  for (const Gesture& gesture : gestures()) {
    if (gesture.name == name) return gesture;
    known.emplace_back(gesture.name);
  }
  fail("no gesture is named '{}'; known: {}", name, joined(known));
}

}  // namespace knuckle
