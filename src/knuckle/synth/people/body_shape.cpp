// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people/body_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

/// The skin ends about this far beyond the middle finger's tip landmark (measured on the mean adult).
constexpr float kSkinBeyondTipMm = 1.5f;

/// The share that a person has of a group of one property: "young", 0.7.
struct Share {
  std::string_view group;
  double value;
};

// MakeHuman's age axis: 0 newborn, 0.1875 child, 0.5 young adult, 1 old; between them the shares are linear.
constexpr double kChildAge = 0.1875;
constexpr double kYoungAge = 0.5;

std::array<Share, 2> gender_shares(double gender) {
  return {{{"female", 1.0 - gender}, {"male", gender}}};
}

std::array<Share, 3> age_shares(double age) {
  const double young = age < kYoungAge ? (age - kChildAge) / (kYoungAge - kChildAge) : 2.0 - 2.0 * age;
  return {{{"child", age < kYoungAge ? 1.0 - young : 0.0},
           {"young", young},
           {"old", age < kYoungAge ? 0.0 : 1.0 - young}}};
}

/// Shares of the low, middle and high group of a property whose middle is 0.5.
std::array<double, 3> low_middle_high(double value) {
  const double low = std::max(0.0, 1.0 - 2.0 * value);
  const double high = std::max(0.0, 2.0 * value - 1.0);
  return {low, 1.0 - low - high, high};
}

std::array<Share, 3> muscle_shares(double muscle) {
  const auto [low, middle, high] = low_middle_high(muscle);
  return {{{"minmuscle", low}, {"averagemuscle", middle}, {"maxmuscle", high}}};
}

std::array<Share, 3> weight_shares(double weight) {
  const auto [low, middle, high] = low_middle_high(weight);
  return {{{"minweight", low}, {"averageweight", middle}, {"maxweight", high}}};
}

/// The middle height has no targets of its own.
std::array<Share, 2> height_shares(double height) {
  const auto [low, middle, high] = low_middle_high(height);
  return {{{"minheight", low}, {"maxheight", high}}};
}

std::array<Share, 3> ancestry_shares(const PersonShape& person) {
  const double sum = person.african + person.asian + person.caucasian;
  if (!(sum > 0.0)) fail("person: african, asian and caucasian are all 0, expected one above 0");
  return {{{"african", person.african / sum},
           {"asian", person.asian / sum},
           {"caucasian", person.caucasian / sum}}};
}

std::vector<WeightedTarget> macro_targets(const PersonShape& person) {
  std::vector<WeightedTarget> targets;
  for (const Share& gender : gender_shares(person.gender)) {
    for (const Share& age : age_shares(person.age)) {
      const double person_share = gender.value * age.value;
      for (const Share& ancestry : ancestry_shares(person)) {
        targets.push_back({fmt::format("macrodetails/{}-{}-{}", ancestry.group, gender.group, age.group),
                           person_share * ancestry.value});
      }
      for (const Share& muscle : muscle_shares(person.muscle)) {
        for (const Share& weight : weight_shares(person.weight)) {
          const std::string build =
              fmt::format("{}-{}-{}-{}", gender.group, age.group, muscle.group, weight.group);
          const double share = person_share * muscle.value * weight.value;
          targets.push_back({"macrodetails/universal-" + build, share});
          for (const Share& height : height_shares(person.height)) {
            targets.push_back(
                {fmt::format("macrodetails/height/{}-{}", build, height.group), share * height.value});
          }
        }
      }
    }
  }
  return targets;
}

/// A pair of targets of the right arm: one for values below 0, one for values above.
struct DetailTarget {
  double PersonShape::*value;
  std::string_view below;
  std::string_view above;
};

constexpr std::array<DetailTarget, 10> kDetailTargets{{
    {&PersonShape::hand_scale, "r-hand-scale-decr", "r-hand-scale-incr"},
    {&PersonShape::finger_length, "r-hand-fingers-length-decr", "r-hand-fingers-length-incr"},
    {&PersonShape::finger_thickness, "r-hand-fingers-diameter-decr", "r-hand-fingers-diameter-incr"},
    {&PersonShape::finger_spread, "r-hand-fingers-distance-decr", "r-hand-fingers-distance-incr"},
    {&PersonShape::hand_shift, "r-hand-trans-in", "r-hand-trans-out"},
    {&PersonShape::forearm_fat, "r-lowerarm-skinny", "r-lowerarm-fat"},
    {&PersonShape::forearm_muscle, "r-lowerarm-muscle-decr", "r-lowerarm-muscle-incr"},
    {&PersonShape::forearm_length, "r-lowerarm-scale-vert-decr", "r-lowerarm-scale-vert-incr"},
    {&PersonShape::forearm_breadth, "r-lowerarm-scale-horiz-decr", "r-lowerarm-scale-horiz-incr"},
    {&PersonShape::forearm_depth, "r-lowerarm-scale-depth-decr", "r-lowerarm-scale-depth-incr"},
}};

std::vector<WeightedTarget> detail_targets(const PersonShape& person) {
  std::vector<WeightedTarget> targets;
  for (const DetailTarget& detail : kDetailTargets) {
    const double value = person.*detail.value;
    targets.push_back({fmt::format("armslegs/{}", detail.below), std::max(0.0, -value)});
    targets.push_back({fmt::format("armslegs/{}", detail.above), std::max(0.0, value)});
  }
  return targets;
}

/// All targets in a fixed order, those with weight 0 too.
std::vector<WeightedTarget> all_targets(const PersonShape& person) {
  check_options(person, "person");
  std::vector<WeightedTarget> targets = macro_targets(person);
  std::ranges::move(detail_targets(person), std::back_inserter(targets));
  return targets;
}

}  // namespace

void PersonShape::visit(OptionVisitor& visitor) {
  visitor.real("gender", gender, closed(0, 1));
  visitor.real("age", age, closed(kChildAge, 1));
  visitor.real("weight", weight, closed(0, 1));
  visitor.real("muscle", muscle, closed(0, 1));
  visitor.real("height", height, closed(0, 1));
  visitor.real("african", african, closed(0, 1));
  visitor.real("asian", asian, closed(0, 1));
  visitor.real("caucasian", caucasian, closed(0, 1));
  visitor.real("hand_scale", hand_scale, closed(-1, 1));
  visitor.real("finger_length", finger_length, closed(-1, 1));
  visitor.real("finger_thickness", finger_thickness, closed(-1, 1));
  visitor.real("finger_spread", finger_spread, closed(-1, 1));
  visitor.real("hand_shift", hand_shift, closed(-1, 1));
  visitor.real("forearm_fat", forearm_fat, closed(-1, 1));
  visitor.real("forearm_muscle", forearm_muscle, closed(-1, 1));
  visitor.real("forearm_length", forearm_length, closed(-1, 1));
  visitor.real("forearm_breadth", forearm_breadth, closed(-1, 1));
  visitor.real("forearm_depth", forearm_depth, closed(-1, 1));
}

std::vector<WeightedTarget> weighted_targets(const PersonShape& person) {
  std::vector<WeightedTarget> targets = all_targets(person);
  std::erase_if(targets, [](const WeightedTarget& target) { return target.weight == 0.0; });
  return targets;
}

std::vector<double> shape_coefficients(const Body& body, const PersonShape& person) {
  std::unordered_map<std::string_view, std::size_t> place;
  for (std::size_t i = 0; i < body.shapedirs.size(); ++i) place[body.shapedirs[i].name] = i;
  std::vector<double> coefficients(body.shapedirs.size(), 0.0);
  for (const WeightedTarget& target : weighted_targets(person)) {
    const auto found = place.find(target.name);
    if (found == place.end()) fail("the body has no shape direction '{}'", target.name);
    coefficients[found->second] = target.weight;
  }
  return coefficients;
}

double hand_length_mm(const ShapedBody& person) {
  const auto landmark = [&](Landmark which) { return person.landmarks[static_cast<std::size_t>(which)]; };
  const Eigen::Vector3f tip = landmark(Landmark::middle_tip);
  const Eigen::Vector3f beyond = (tip - landmark(Landmark::middle_dip)).normalized() * kSkinBeyondTipMm;
  return (tip + beyond - landmark(Landmark::wrist)).norm();
}

PersonShape with_hand_length(const Body& body, PersonShape person, double length_mm) {
  const auto length_at = [&](double scale) {
    person.hand_scale = scale;
    return hand_length_mm(shaped_body(body, shape_coefficients(body, person)));
  };
  // Length is linear in the scale on each side of 0: two chords that start there are exact.
  const double plain = length_at(0.0);
  const double end = length_mm < plain ? -1.0 : 1.0;
  person.hand_scale = end * std::clamp((length_mm - plain) / (length_at(end) - plain), 0.0, 1.0);
  return person;
}

std::vector<std::string> person_target_names() {
  std::vector<std::string> names;
  for (WeightedTarget& target : all_targets(PersonShape{})) names.push_back(std::move(target.name));
  return names;
}

}  // namespace knuckle
