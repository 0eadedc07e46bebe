// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/random.h"
#include "knuckle/synth/body_shape.h"

namespace knuckle {

/// A random adult, as many women as men. Age is uniform over 18 to about 65 years, stature, weight and muscle
/// are normal about the mean, ancestries are mixed evenly. Hand lengths are normal with the means and
/// deviations of a survey (women 181 and 10 mm, men 193 and 10 mm: ANSUR II, 2012); finger length, thickness
/// and spread and the forearm vary about that normally.
PersonShape sampled_person(const Body& body, Random& random);

}  // namespace knuckle
