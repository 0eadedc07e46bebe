// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace knuckle {

/// The angles that bend a hand [rad]. All 0 is the straight hand: fingers straight, parallel to the middle
/// metacarpal, in the plane of the palm; the thumb straight, in the plane of the palm, beside the index
/// finger.
enum class HandAngle : std::uint8_t {
  thumb_radial,  ///< of the metacarpal in the plane of the palm, away from the index finger
  thumb_palmar,  ///< of the metacarpal out of the plane of the palm, towards its front
  thumb_twist,   ///< of the metacarpal about itself, towards opposition, beyond what goes with thumb_palmar
  thumb_mcp,     ///< flexion
  thumb_ip,      ///< flexion
  index_mcp,     ///< flexion
  index_spread,  ///< away from the middle finger; of the middle finger itself: towards the thumb
  index_pip,     ///< flexion
  index_dip,     ///< flexion
  middle_mcp,
  middle_spread,
  middle_pip,
  middle_dip,
  ring_mcp,
  ring_spread,
  ring_pip,
  ring_dip,
  little_mcp,
  little_spread,
  little_pip,
  little_dip,
  palm_arch,  ///< flexion of the little metacarpal; the ring metacarpal follows by half
};

/// Number of angles of a hand.
inline constexpr int kHandAngleCount = 22;

/// The angle's name as records write it, for example "index_pip".
std::string_view name_of(HandAngle angle);

/// One value per angle of the hand [rad].
struct HandAngles {
  std::array<double, kHandAngleCount> radians{};

  double& operator[](HandAngle angle) { return radians[static_cast<std::size_t>(angle)]; }
  double operator[](HandAngle angle) const { return radians[static_cast<std::size_t>(angle)]; }
  bool operator==(const HandAngles&) const = default;
};

/// The angles of one finger: 0 index to 3 little.
struct FingerAngleNames {
  HandAngle mcp;
  HandAngle spread;
  HandAngle pip;
  HandAngle dip;
};
/// The angles of a finger: 0 index, 1 middle, 2 ring, 3 little.
FingerAngleNames angles_of_finger(int finger);

/// How far an angle goes by itself [rad].
struct AngleRange {
  double low = 0.0;
  double high = 0.0;
};

/// What angles a hand can take: each in its range; the DIP near its coupling to the PIP; less spread the more
/// an MCP is bent, as its ligaments tighten.
struct HandLimits {
  std::array<AngleRange, kHandAngleCount> ranges;  ///< in the order of HandAngle [rad]
  double dip_below_coupling = 0.0;                 ///< how far a DIP may stay behind `coupled_dip` [rad]
  double dip_above_coupling = 0.0;                 ///< how far it may exceed it [rad]
  double spread_left_when_bent =
      1.0;  ///< part of an MCP's spread that is left where it is bent by 90 degrees

  const AngleRange& operator[](HandAngle angle) const { return ranges[static_cast<std::size_t>(angle)]; }
};

/// The limits of healthy adults.
const HandLimits& healthy_limits();

/// The range of an angle in a healthy hand.
AngleRange range_of(HandAngle angle);

/// Throws an Error that starts with `what` where a number is not finite, a range is reversed or exceeds half
/// a turn, a distance from the coupling is negative, or the spread that is left is not in [0, 1].
void check(const HandLimits& limits, std::string_view what);

/// How far the DIP bends by itself where the PIP bends by `pip`: two thirds (Lin, Wu and Huang, "Modeling the
/// constraints of human hand motion", 2000).
inline double coupled_dip(double pip) {
  return pip * (2.0 / 3.0);
}

/// Angles that a hand can take: each of these brought into its limits, the MCPs and PIPs first. What is
/// within the limits stays as it is.
HandAngles clamped(HandAngles angles, const HandLimits& limits = healthy_limits());

/// Whether a hand can take these angles; not where one is NaN.
bool within_limits(const HandAngles& angles, const HandLimits& limits = healthy_limits());

/// (1 - t) a + t b, angle by angle.
HandAngles interpolated(const HandAngles& a, const HandAngles& b, double t);

}  // namespace knuckle
