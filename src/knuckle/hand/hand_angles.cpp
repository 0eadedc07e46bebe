// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_angles.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/angle.h"

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

/// How far the DIP strays from its coupling: pressed back against a thing, or hooked.
constexpr double kDipBelowCoupling = 45.0 * kDegree;
constexpr double kDipAboveCoupling = 20.0 * kDegree;
/// What is left of an MCP's spread when it is bent by 90 degrees.
constexpr double kSpreadLeftWhenBent = 0.25;

double spread_left(double mcp) {
  const double bent = std::clamp(mcp / (90.0 * kDegree), 0.0, 1.0);
  return 1.0 - (1.0 - kSpreadLeftWhenBent) * bent;
}

void limit_finger(HandAngles& angles, const FingerAngleNames& finger) {
  const AngleRange spread = range_of(finger.spread);
  const double left = spread_left(angles[finger.mcp]);
  angles[finger.spread] = std::clamp(angles[finger.spread], spread.low * left, spread.high * left);
  const double coupled = coupled_dip(angles[finger.pip]);
  const AngleRange dip = range_of(finger.dip);
  angles[finger.dip] = std::clamp(angles[finger.dip], std::max(dip.low, coupled - kDipBelowCoupling),
                                  std::min(dip.high, coupled + kDipAboveCoupling));
}

}  // namespace

FingerAngleNames angles_of_finger(int finger) {
  constexpr int kAnglesPerFinger = 4;
  const int first = static_cast<int>(HandAngle::index_mcp) + kAnglesPerFinger * finger;
  return {static_cast<HandAngle>(first), static_cast<HandAngle>(first + 1), static_cast<HandAngle>(first + 2),
          static_cast<HandAngle>(first + 3)};
}

AngleRange range_of(HandAngle angle) {
  const RangeInDegrees& range = kRanges[static_cast<std::size_t>(angle)];
  return {range.low * kDegree, range.high * kDegree};
}

HandAngles within_limits(HandAngles angles) {
  for (int i = 0; i < kHandAngleCount; ++i) {
    const AngleRange range = range_of(static_cast<HandAngle>(i));
    angles.radians[i] = std::clamp(angles.radians[i], range.low, range.high);
  }
  for (int finger = 0; finger < 4; ++finger) limit_finger(angles, angles_of_finger(finger));
  return angles;
}

HandAngles interpolated(const HandAngles& a, const HandAngles& b, double t) {
  HandAngles result;
  for (int i = 0; i < kHandAngleCount; ++i) {
    result.radians[i] = (1.0 - t) * a.radians[i] + t * b.radians[i];
  }
  return result;
}

}  // namespace knuckle
