// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/options.h"
#include "knuckle/hand/body.h"
#include "knuckle/hand/skinning.h"

namespace knuckle {

/// The shape of a person in MakeHuman's terms. The first seven mix whole bodies ("macro" targets) and 0.5 is
/// the middle; the others are changes of the right hand and forearm that are added, and 0 is none. The
/// defaults are the mean of an adult woman and an adult man of 25 years.
struct PersonShape {
  double gender = 0.5;  ///< 0 woman, 1 man, [0, 1]
  double age = 0.5;     ///< 0.1875 a child of about 10 years, 0.5 is 25, 1 is 90 years, [0.1875, 1]
  double weight = 0.5;  ///< 0 lean, 1 heavy, [0, 1]
  double muscle = 0.5;  ///< 0 slack, 1 athlete, [0, 1]
  /// 0.5 mean stature, [0, 1]. The ends are no people: a step of 0.1 is about 145 mm of a man's stature
  /// upwards and 73 mm downwards, so adults lie in about [0.35, 0.6].
  double height = 0.5;
  double african = 1.0;  ///< share of MakeHuman's ancestry targets, [0, 1]; the three are scaled to sum to 1
  double asian = 1.0;    ///< the same
  double caucasian = 1.0;  ///< the same

  double hand_scale = 0.0;        ///< whole hand smaller or larger, [-1, 1]
  double finger_length = 0.0;     ///< [-1, 1]
  double finger_thickness = 0.0;  ///< [-1, 1]
  double finger_spread = 0.0;     ///< gaps between the fingers at rest, [-1, 1]
  double hand_shift = 0.0;        ///< hand moved against the forearm, inwards to outwards, [-1, 1]
  double forearm_fat = 0.0;       ///< [-1, 1]
  double forearm_muscle = 0.0;    ///< [-1, 1]
  double forearm_length = 0.0;    ///< [-1, 1]
  double forearm_breadth = 0.0;   ///< [-1, 1]
  double forearm_depth = 0.0;     ///< [-1, 1]

  void visit(OptionVisitor& visitor);
};

/// A shape direction with the weight that a person gives it.
struct WeightedTarget {
  std::string name;
  double weight = 0.0;
};

/// MakeHuman's targets that make this person, with weights above 0. The weight of a macro target is the
/// product of the factors that its name lists (MakeHuman 1.1's macro modelling: gender, age group, muscle and
/// weight group, height group, ancestry); each factor is a hat function of one property, so the weights of a
/// family sum to 1 or less. Throws an Error that names the field where one is out of its range.
std::vector<WeightedTarget> weighted_targets(const PersonShape& person);

/// The coefficients of this person for `shaped_body`, one per shape direction. Throws an Error where a field
/// is out of its range, or where the body lacks a direction that the person needs.
std::vector<double> shape_coefficients(const Body& body, const PersonShape& person);

/// Length of the right hand at rest [mm] as anthropometry measures it: straight from the wrist's crease to
/// the end of the middle finger.
double hand_length_mm(const ShapedBody& person);

/// The person with `hand_scale` set such that the hand has this length, or as near as [-1, 1] allows:
/// MakeHuman's women have smaller and its men larger hands than surveys find (ANSUR II, 2012: 181 and 193 mm
/// on average).
PersonShape with_hand_length(const Body& body, PersonShape person, double length_mm);

/// The names of all targets that a PersonShape can ask for: the shape directions of a body made from
/// MakeHuman.
std::vector<std::string> person_target_names();

}  // namespace knuckle
