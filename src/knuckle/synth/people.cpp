// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people.h"

#include <algorithm>

namespace knuckle {
namespace {

/// Normal, but never farther than two and a half deviations from the mean.
double bounded_normal(double mean, double deviation, Random& random) {
  return mean + deviation * std::clamp(random.normal(), -2.5, 2.5);
}

}  // namespace

PersonShape sampled_person(const Body& body, Random& random) {
  PersonShape person;
  const bool is_man = random.below(2) == 1;
  person.gender = is_man ? random.uniform(0.75, 1.0) : random.uniform(0.0, 0.25);
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
  return with_hand_length(body, person, bounded_normal(is_man ? 193.0 : 181.0, 10.0, random));
}

}  // namespace knuckle
