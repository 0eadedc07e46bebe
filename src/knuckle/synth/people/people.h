// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/random.h"
#include "knuckle/synth/people/body_shape.h"
#include "knuckle/synth/people/hand_proportions.h"

namespace knuckle {

/// One person: a shape, and the proportions of the right hand.
struct Person {
  PersonShape shape;
  HandProportions proportions;
};

/// A random adult, as many women as men. Age is uniform over 18 to about 65 years, stature, weight and muscle
/// are normal about the mean, ancestries are mixed evenly; finger length, thickness and spread and the
/// forearm vary about that normally.
///
/// Hand length and hand breadth are normal with the means and deviations of surveys: women 181 and 10 mm, men
/// 193 and 10 mm long (ANSUR II: Gordon et al., "2012 anthropometric survey of US Army personnel", 2014);
/// women 79 and 4 mm, men 90 and 4 mm broad (Greiner, "Hand anthropometry of US Army personnel", 1991), with
/// a correlation of 0.6 within a sex. What is beyond two and a half deviations does not occur.
///
/// `bone_spread` is the deviation of `sampled_proportions`.
Person sampled_person(const Body& body, double bone_spread, Random& random);

/// The body of this person.
ShapedBody shaped_body(const Body& body, const Person& person);

}  // namespace knuckle
