// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/pose/hand_sampler.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string_view>

#include "knuckle/core/angle.h"
#include "knuckle/synth/pose/gestures.h"
#include "knuckle/synth/pose/touching_thumb.h"

namespace knuckle {
namespace {

constexpr int kAnglesPerFinger = 4;
/// Share of grasps in which the thing bends the thumb's end joint back.
constexpr double kPressedThumb = 0.7;
/// How far a DIP follows its PIP where the finger tip is pressed on a thing.
constexpr double kPressedDip = 0.45;

constexpr std::array<std::string_view, 5> kClosed = {"fist", "fist_thumb_beside", "loose_fist",
                                                     "small_cylinder", "thumb_up"};
constexpr std::array<std::string_view, 5> kOpen = {"open", "spread", "flat", "relaxed", "flat_thumb_in"};
/// Those whose thumb lies over bent fingers.
constexpr std::array<std::string_view, 5> kThumbOver = {"fist", "loose_fist", "point", "little_up",
                                                        "middle_up"};

bool is_allowed(const HandPoseOptions& options, std::string_view name) {
  const auto holds = [&](const std::vector<std::string>& names) {
    return std::ranges::find(names, name) != names.end();
  };
  return (options.gestures.empty() || holds(options.gestures)) && !holds(options.without_gestures);
}

/// Those of some gestures that may be drawn.
template <class Names>
std::vector<std::string_view> allowed_of(const Names& names, const HandPoseOptions& options) {
  std::vector<std::string_view> allowed;
  for (const std::string_view name : names) {
    if (is_allowed(options, name)) allowed.push_back(name);
  }
  return allowed;
}

const std::vector<std::string_view>& gesture_names() {
  static const std::vector<std::string_view> all_names = [] {
    std::vector<std::string_view> names;
    for (const Gesture& gesture : gestures()) names.push_back(gesture.name);
    return names;
  }();
  return all_names;
}

const HandAngles& any_of(const std::vector<std::string_view>& names, Random& random) {
  return gesture_from_name(names[random.below(static_cast<std::uint32_t>(names.size()))]).angles;
}

const HandAngles& any_gesture(const HandPoseOptions& options, Random& random) {
  std::vector<const Gesture*> allowed;
  for (const Gesture& gesture : gestures()) {
    if (is_allowed(options, gesture.name)) allowed.push_back(&gesture);
  }
  return allowed[random.below(static_cast<std::uint32_t>(allowed.size()))]->angles;
}

HandAngles between_gestures(const HandPoseOptions& options, Random& random) {
  const HandAngles& from = any_gesture(options, random);
  const HandAngles& to = any_gesture(options, random);
  return interpolated(from, to, random.uniform());
}

/// The digit (0 thumb to 4 little, 5 the palm) that an angle belongs to.
int digit_of(int angle) {
  if (angle < kThumbAngleCount) return 0;
  return 1 + (angle - kThumbAngleCount) / kAnglesPerFinger;
}

HandAngles with_digits(const std::array<HandAngles, 6>& digits) {
  HandAngles result;
  for (int i = 0; i < kHandAngleCount; ++i) result.radians[i] = digits[digit_of(i)].radians[i];
  return result;
}

HandAngles mixed_digits(const HandPoseOptions& options, Random& random) {
  std::array<HandAngles, 6> digits;
  for (HandAngles& digit : digits) digit = between_gestures(options, random);
  return with_digits(digits);
}

/// On the way from a closed to an open hand; each digit runs a little ahead or behind.
HandAngles closing_hand(const HandPoseOptions& options, Random& random) {
  constexpr double kLag = 0.12;
  const HandAngles closed_hand = any_of(allowed_of(kClosed, options), random);
  const HandAngles open_hand = any_of(allowed_of(kOpen, options), random);
  const double t = random.uniform();
  std::array<HandAngles, 6> digits;
  for (HandAngles& digit : digits) {
    digit = interpolated(closed_hand, open_hand, std::clamp(t + kLag * random.normal(), 0.0, 1.0));
  }
  return with_digits(digits);
}

double within(HandAngle angle, double share) {
  const AngleRange range = range_of(angle);
  return range.low + share * (range.high - range.low);
}

/// Anywhere within the limits, but fingers bend together, as tendons and habit make them: each kind of joint
/// shares a level that is uniform over its range.
HandAngles uniform_hand(Random& random) {
  constexpr double kOwnWay = 0.18;  ///< deviation of one finger from the others, in parts of the range
  HandAngles angles;
  for (int i = 0; i < kThumbAngleCount; ++i) {
    const auto angle = static_cast<HandAngle>(i);
    angles[angle] = within(angle, random.uniform());
  }
  const double mcp_level = random.uniform();
  const double pip_level = random.uniform();
  const double spread_level = random.uniform();
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    angles[names.mcp] = within(names.mcp, mcp_level + kOwnWay * random.normal());
    angles[names.spread] = within(names.spread, spread_level + kOwnWay * random.normal());
    angles[names.pip] = within(names.pip, pip_level + kOwnWay * random.normal());
    angles[names.dip] = coupled_dip(angles[names.pip]) + 12.0 * kDegree * random.normal();
  }
  angles[HandAngle::palm_arch] = within(HandAngle::palm_arch, random.uniform());
  return angles;
}

/// Around a thing. Few things vary, as in real grasps (Santello, Flanders and Soechting, "Postural hand
/// synergies for tool use", 1998: the MCPs bend together, so do the PIPs, and the first two components
/// explain four fifths): how far the MCPs bend and how far the PIPs, each changing evenly from index to
/// little; the index finger goes its own way more than the others. The thing presses on the finger tips: DIPs
/// follow their PIPs by less than half, and the thumb's end joint may give way backwards. Fingers drift
/// together to the little finger's side, as they do where a hand closes with force.
HandAngles grasping_hand(Random& random) {
  const auto normal = [&](double mean_deg, double deviation_deg) {
    return (mean_deg + deviation_deg * random.normal()) * kDegree;
  };
  HandAngles angles;
  angles[HandAngle::thumb_radial] = normal(20, 17);
  angles[HandAngle::thumb_palmar] = normal(41, 10);
  angles[HandAngle::thumb_twist] = normal(5, 18);
  angles[HandAngle::thumb_mcp] = normal(12, 9);
  angles[HandAngle::thumb_ip] = random.uniform() < kPressedThumb ? normal(-8, 14) : normal(35, 22);
  const double mcp = random.uniform(5.0, 68.0);
  const double mcp_slope = 4.0 * random.normal();
  const double pip = random.uniform(5.0, 90.0);
  const double pip_slope = 5.0 * random.normal();
  const double dip = 12.0 + 8.0 * random.normal();
  const double drift = 4.0 + 4.0 * random.normal();
  const double fan = random.uniform(-2.0, 8.0);
  constexpr std::array<double, 4> kOwnWay = {10.0, 4.0, 4.0, 6.0};
  for (int finger = 0; finger < 4; ++finger) {
    const FingerAngleNames names = angles_of_finger(finger);
    angles[names.mcp] = normal(mcp + mcp_slope * (finger - 1.5), kOwnWay[finger]);
    angles[names.pip] = normal(pip + pip_slope * (finger - 1.5), 1.2 * kOwnWay[finger]);
    angles[names.dip] = kPressedDip * angles[names.pip] + normal(dip, 5);
    // Away from the middle finger is towards the thumb for index and middle, else towards the little finger.
    const double away = finger == 0 ? fan : finger == 1 ? 0.0 : fan * (finger == 3 ? 1.5 : 0.5);
    angles[names.spread] = normal(away + (finger <= 1 ? -drift : drift), 2.5);
  }
  angles[HandAngle::palm_arch] = random.uniform(0.0, 22.0) * kDegree;
  return angles;
}

std::array<double, 7> shares_of(const HandPoseOptions& options) {
  return {options.gesture_share, options.pair_share,    options.mixed_share, options.closing_share,
          options.grasp_share,   options.uniform_share, options.touch_share};
}

HandAngles with_jitter(HandAngles angles, double jitter_deg, Random& random) {
  for (double& angle : angles.radians) angle += jitter_deg * kDegree * random.normal();
  return angles;
}

/// A thumb drawn around that of a gesture.
void set_thumb(HandAngles& hand, std::string_view gesture, double deviation_deg, Random& random) {
  const HandAngles& thumb = gesture_from_name(gesture).angles;
  for (int i = 0; i < kThumbAngleCount; ++i) {
    hand.radians[i] = thumb.radians[i] + deviation_deg * kDegree * random.normal();
  }
}

/// The thumb's tip meets that of a finger, most often the index finger: rings from narrow to flat, pinches,
/// counting on fingers. The other fingers are open, or anything.
HandAngles pinching_hand(const HandPoseOptions& options, Random& random) {
  const bool is_open = random.uniform() < 0.5;
  HandAngles hand =
      with_jitter(is_open ? any_of(allowed_of(kOpen, options), random) : mixed_digits(options, random),
                  options.jitter_deg, random);
  const double which = random.uniform();
  const int finger = which < 0.6 ? 0 : which < 0.8 ? 1 : which < 0.9 ? 2 : 3;
  const FingerAngleNames names = angles_of_finger(finger);
  hand[names.mcp] = random.uniform(10.0, 75.0) * kDegree;
  hand[names.pip] = random.uniform(20.0, 105.0) * kDegree;
  hand[names.dip] = random.uniform(0.3, 1.1) * coupled_dip(hand[names.pip]);
  set_thumb(hand, "ok", 10.0, random);
  return with_touching_thumb(hand, {.finger = finger,
                                    .bone = 2,
                                    .along = random.uniform(0.4, 1.0),
                                    .distance_mm = random.uniform(11.0, 18.0)});
}

/// A thumb that lies across bent fingers, on the middle bone of one of them.
HandAngles crossing_thumb(const HandPoseOptions& options, Random& random) {
  constexpr double kBent = 60.0 * kDegree;
  HandAngles hand = with_jitter(any_of(allowed_of(kThumbOver, options), random), options.jitter_deg, random);
  int finger = static_cast<int>(random.below(3));
  for (int tried = 0; tried < 3 && hand[angles_of_finger(finger).pip] < kBent; ++tried)
    finger = (finger + 1) % 3;
  set_thumb(hand, "fist", 10.0, random);
  hand[HandAngle::thumb_mcp] = random.uniform(10.0, 50.0) * kDegree;
  hand[HandAngle::thumb_ip] = random.uniform(0.0, 75.0) * kDegree;
  return with_touching_thumb(
      hand,
      {.finger = finger, .bone = 1, .along = random.uniform(), .distance_mm = random.uniform(14.0, 20.0)});
}

/// A thumb that touches a finger.
HandAngles touching_hand(const HandPoseOptions& options, Random& random) {
  constexpr double kPinches = 0.55;
  return random.uniform() < kPinches ? pinching_hand(options, random) : crossing_thumb(options, random);
}

HandAngles unlimited_hand(const HandPoseOptions& options, Random& random) {
  const std::array<double, 7> shares = shares_of(options);
  double left = random.uniform() * std::accumulate(shares.begin(), shares.end(), 0.0);
  std::size_t kind = 0;
  while (kind + 1 < shares.size() && left >= shares[kind]) left -= shares[kind++];
  switch (kind) {
    case 0:
      return with_jitter(any_gesture(options, random), options.jitter_deg, random);
    case 1:
      return with_jitter(between_gestures(options, random), options.jitter_deg, random);
    case 2:
      return with_jitter(mixed_digits(options, random), options.jitter_deg, random);
    case 3:
      return with_jitter(closing_hand(options, random), options.jitter_deg, random);
    case 4:
      return grasping_hand(random);
    case 5:
      return uniform_hand(random);
    default:
      return touching_hand(options, random);
  }
}

}  // namespace

void HandPoseOptions::visit(OptionVisitor& visitor) {
  visitor.real("gesture_share", gesture_share, at_least(0));
  visitor.real("pair_share", pair_share, at_least(0));
  visitor.real("mixed_share", mixed_share, at_least(0));
  visitor.real("closing_share", closing_share, at_least(0));
  visitor.real("grasp_share", grasp_share, at_least(0));
  visitor.real("uniform_share", uniform_share, at_least(0));
  visitor.real("touch_share", touch_share, at_least(0));
  visitor.real("jitter_deg", jitter_deg, closed(0, 45));
  visitor.real("penetration_mm", penetration_mm, at_least(0));
  visitor.texts("gestures", gestures, gesture_names());
  visitor.texts("without_gestures", without_gestures, gesture_names());
}

std::vector<std::string_view> allowed_gestures(const HandPoseOptions& options) {
  return allowed_of(gesture_names(), options);
}

void check(const HandPoseOptions& options, std::string_view what) {
  check_options(options, what);
  const std::array<double, 7> shares = shares_of(options);
  if (std::accumulate(shares.begin(), shares.end(), 0.0) <= 0.0) {
    fail(
        "{}: all of gesture_share, pair_share, mixed_share, closing_share, grasp_share, uniform_share and "
        "touch_share are 0; expected one above 0",
        what);
  }
  const bool needs_gestures =
      options.gesture_share + options.pair_share + options.mixed_share + options.touch_share > 0.0;
  if (needs_gestures && allowed_gestures(options).empty()) {
    fail("{}: gestures and without_gestures leave none to draw from", what);
  }
  if (options.closing_share > 0.0 &&
      (allowed_of(kClosed, options).empty() || allowed_of(kOpen, options).empty())) {
    fail("{}: closing_share is {}, but gestures and without_gestures leave no closed or no open hand", what,
         options.closing_share);
  }
  if (options.touch_share > 0.0 &&
      (allowed_of(kOpen, options).empty() || allowed_of(kThumbOver, options).empty())) {
    fail(
        "{}: touch_share is {}, but gestures and without_gestures leave no open hand or no thumb over a fist",
        what, options.touch_share);
  }
}

HandAngles sampled_hand(const HandPoseOptions& options, Random& random) {
  return clamped(unlimited_hand(options, random));
}

}  // namespace knuckle
