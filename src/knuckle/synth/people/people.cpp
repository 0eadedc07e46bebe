// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people/people.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

/// Normal, but never farther than two and a half deviations from the mean.
double bounded_normal(double mean, double deviation, Random& random) {
  return mean + deviation * std::clamp(random.normal(), -2.5, 2.5);
}

struct Survey {
  double length_mm;
  double breadth_mm;
};
constexpr Survey kWomen = {181.0, 79.0};
constexpr Survey kMen = {193.0, 90.0};
constexpr Survey kDeviation = {10.0, 4.0};
/// Of length and breadth within one sex.
constexpr double kCorrelation = 0.6;

PersonShape sampled_shape(double gender, Random& random) {
  PersonShape person;
  person.gender = gender;
  person.age = random.uniform(0.4, 0.8);  // 0.5 is 25 years, 1 is 90
  person.weight = bounded_normal(0.5, 0.15, random);
  person.muscle = bounded_normal(0.5, 0.15, random);
  person.height = bounded_normal(0.475, 0.04, random);
  person.african = random.uniform();
  person.asian = random.uniform();
  person.caucasian = random.uniform(0.01, 1.0);  // they must not all be 0
  person.finger_length = bounded_normal(0.0, 0.25, random);
  person.finger_thickness = bounded_normal(0.0, 0.3, random);
  person.finger_spread = bounded_normal(0.0, 0.3, random);
  person.forearm_fat = bounded_normal(0.0, 0.3, random);
  person.forearm_muscle = bounded_normal(0.0, 0.3, random);
  person.forearm_length = bounded_normal(0.0, 0.2, random);
  person.forearm_breadth = bounded_normal(0.0, 0.25, random);
  person.forearm_depth = bounded_normal(0.0, 0.25, random);
  return person;
}

/// The person whose hand has this length and breadth: the shape is scaled, then the palm widened.
Person fitted(const Body& body, Person person, const Survey& hand) {
  const ShapedBody before = shaped_body(body, shape_coefficients(body, person.shape));
  const double stretched = hand_length_mm(with_proportions(before, person.proportions));
  person.shape = with_hand_length(body, person.shape, hand.length_mm * hand_length_mm(before) / stretched);
  const ShapedBody scaled = shaped_body(body, shape_coefficients(body, person.shape));
  constexpr int kSteps = 4;  // each leaves a third of what is missing
  for (int step = 0; step < kSteps; ++step) {
    person.proportions.palm_breadth *=
        hand.breadth_mm / hand_breadth_mm(with_proportions(scaled, person.proportions));
  }
  return person;
}

}  // namespace

Person sampled_person(const Body& body, double bone_spread, Random& random) {
  const bool is_man = random.below(2) == 1;
  const double gender = is_man ? random.uniform(0.75, 1.0) : random.uniform(0.0, 0.25);
  const Person person{sampled_shape(gender, random), sampled_proportions(bone_spread, random)};
  const Survey& mean = is_man ? kMen : kWomen;
  const double length = bounded_normal(0.0, 1.0, random);
  const double own_breadth = bounded_normal(0.0, std::sqrt(1.0 - kCorrelation * kCorrelation), random);
  return fitted(body, person,
                {mean.length_mm + kDeviation.length_mm * length,
                 mean.breadth_mm + kDeviation.breadth_mm * (kCorrelation * length + own_breadth)});
}

ShapedBody shaped_body(const Body& body, const Person& person) {
  return with_proportions(shaped_body(body, shape_coefficients(body, person.shape)), person.proportions);
}

}  // namespace knuckle
