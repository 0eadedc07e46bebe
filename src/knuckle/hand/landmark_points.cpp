// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/landmark_points.h"

#include <algorithm>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr int kLandmarksPerDigit = 4;
constexpr int kFirstOfDigits = static_cast<int>(Landmark::thumb_cmc);

}  // namespace

HandBone carrier_of(Landmark landmark) {
  const int number = static_cast<int>(landmark);
  if (number >= kSupersetSize) {
    fail("landmark '{}' belongs to one data set; expected one of knuckle22", name_of(landmark));
  }
  if (number < kFirstOfDigits) return HandBone::palm;
  const int digit = (number - kFirstOfDigits) / kLandmarksPerDigit;
  const int joint = (number - kFirstOfDigits) % kLandmarksPerDigit;
  return bone_of_digit(digit, std::min(joint, 2));
}

Landmark landmark_of_digit(int digit, int joint) {
  return static_cast<Landmark>(kFirstOfDigits + kLandmarksPerDigit * digit + joint);
}

}  // namespace knuckle
