// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_angles.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "knuckle/core/angle.h"
#include "knuckle/core/error.h"

namespace knuckle {
namespace {

struct RangeInDegrees {
  double low;
  double high;
};

// Ranges of active motion of healthy hands (American Academy of Orthopaedic Surgeons, "Joint motion", 1965;
// Lin, Wu and Huang 2000), with the hyperextension that many people show. In the order of HandAngle.
constexpr std::array<RangeInDegrees, kHandAngleCount> kRanges = {{
    {0, 65},    {-15, 70}, {-25, 35}, {-15, 60}, {-25, 85},  // thumb
    {-25, 95},  {-15, 25}, {-5, 110}, {-10, 80},             // index
    {-25, 95},  {-12, 12}, {-5, 112}, {-10, 80},             // middle
    {-25, 95},  {-12, 20}, {-5, 112}, {-10, 80},             // ring
    {-30, 100}, {-12, 35}, {-5, 110}, {-10, 80},             // little
    {0, 25},                                                 // palm
}};

HandLimits limits_of_healthy_adults() {
  HandLimits limits;
  for (int i = 0; i < kHandAngleCount; ++i) {
    limits.ranges[i] = {kRanges[i].low * kDegree, kRanges[i].high * kDegree};
  }
  // Pressed back against a thing, or hooked.
  limits.dip_below_coupling = 45.0 * kDegree;
  limits.dip_above_coupling = 20.0 * kDegree;
  limits.spread_left_when_bent = 0.25;
  return limits;
}

double spread_left(double mcp, const HandLimits& limits) {
  const double bent = std::clamp(mcp / (90.0 * kDegree), 0.0, 1.0);
  return 1.0 - (1.0 - limits.spread_left_when_bent) * bent;
}

void limit_finger(HandAngles& angles, const FingerAngleNames& finger, const HandLimits& limits) {
  const AngleRange& spread = limits[finger.spread];
  const double left = spread_left(angles[finger.mcp], limits);
  angles[finger.spread] = std::clamp(angles[finger.spread], spread.low * left, spread.high * left);
  const double coupled = coupled_dip(angles[finger.pip]);
  const AngleRange& dip = limits[finger.dip];
  const double low = std::clamp(coupled - limits.dip_below_coupling, dip.low, dip.high);
  const double high = std::clamp(coupled + limits.dip_above_coupling, low, dip.high);
  angles[finger.dip] = std::clamp(angles[finger.dip], low, high);
}

}  // namespace

std::string_view name_of(HandAngle angle) {
  static constexpr std::array<std::string_view, kHandAngleCount> kNames = {
      "thumb_radial",  "thumb_palmar", "thumb_twist", "thumb_mcp",  "thumb_ip",      "index_mcp",
      "index_spread",  "index_pip",    "index_dip",   "middle_mcp", "middle_spread", "middle_pip",
      "middle_dip",    "ring_mcp",     "ring_spread", "ring_pip",   "ring_dip",      "little_mcp",
      "little_spread", "little_pip",   "little_dip",  "palm_arch"};
  return kNames[static_cast<std::size_t>(angle)];
}

FingerAngleNames angles_of_finger(int finger) {
  constexpr int kAnglesPerFinger = 4;
  const int first = static_cast<int>(HandAngle::index_mcp) + kAnglesPerFinger * finger;
  return {static_cast<HandAngle>(first), static_cast<HandAngle>(first + 1), static_cast<HandAngle>(first + 2),
          static_cast<HandAngle>(first + 3)};
}

const HandLimits& healthy_limits() {
  static const HandLimits limits = limits_of_healthy_adults();
  return limits;
}

AngleRange range_of(HandAngle angle) {
  return healthy_limits()[angle];
}

void check(const HandLimits& limits, std::string_view what) {
  for (int i = 0; i < kHandAngleCount; ++i) {
    const AngleRange& range = limits.ranges[i];
    if (!(-std::numbers::pi <= range.low && range.low <= range.high && range.high <= std::numbers::pi)) {
      fail("{}: limits of {} are {:.6g} to {:.6g} rad, expected low <= high, within -pi to pi", what,
           name_of(static_cast<HandAngle>(i)), range.low, range.high);
    }
  }
  for (const auto& [name, value] : {std::pair{"dip_below_coupling", limits.dip_below_coupling},
                                    std::pair{"dip_above_coupling", limits.dip_above_coupling}}) {
    if (!(value >= 0.0 && value <= std::numbers::pi)) {
      fail("{}: {} is {:.6g} rad, expected 0 to pi", what, name, value);
    }
  }
  if (!(limits.spread_left_when_bent >= 0.0 && limits.spread_left_when_bent <= 1.0)) {
    fail("{}: spread_left_when_bent is {:.6g}, expected 0 to 1", what, limits.spread_left_when_bent);
  }
}

HandAngles clamped(HandAngles angles, const HandLimits& limits) {
  for (int i = 0; i < kHandAngleCount; ++i) {
    angles.radians[i] = std::clamp(angles.radians[i], limits.ranges[i].low, limits.ranges[i].high);
  }
  for (int finger = 0; finger < 4; ++finger) limit_finger(angles, angles_of_finger(finger), limits);
  return angles;
}

bool within_limits(const HandAngles& angles, const HandLimits& limits) {
  return clamped(angles, limits) == angles;
}

HandAngles interpolated(const HandAngles& a, const HandAngles& b, double t) {
  HandAngles result;
  for (int i = 0; i < kHandAngleCount; ++i) {
    result.radians[i] = (1.0 - t) * a.radians[i] + t * b.radians[i];
  }
  return result;
}

}  // namespace knuckle
