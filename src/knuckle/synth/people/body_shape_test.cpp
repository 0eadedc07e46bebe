// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people/body_shape.h"

#include <map>
#include <set>

#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using ::knuckle::testing::box_hand_body;
using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

std::map<std::string, double> weights_of(const PersonShape& person) {
  std::map<std::string, double> weights;
  for (const WeightedTarget& target : weighted_targets(person)) weights[target.name] = target.weight;
  return weights;
}

double sum_of(const std::map<std::string, double>& weights, std::string_view start) {
  double sum = 0.0;
  for (const auto& [name, weight] : weights) {
    if (name.starts_with(start)) sum += weight;
  }
  return sum;
}

TEST(BodyShapeTest, MeanAdultMixesEightTargets) {
  const auto weights = weights_of(PersonShape{});
  EXPECT_EQ(weights.size(), 8u);  // a woman and a man: three ancestries and one build each
  EXPECT_DOUBLE_EQ(weights.at("macrodetails/universal-female-young-averagemuscle-averageweight"), 0.5);
  EXPECT_DOUBLE_EQ(weights.at("macrodetails/asian-male-young"), 0.5 / 3.0);
}

TEST(BodyShapeTest, WeightsAreProductsOfTheFactorsInTheName) {
  PersonShape person;
  person.gender = 0.25;
  person.age = 0.8;      // old 0.6, young 0.4
  person.muscle = 0.9;   // high 0.8
  person.weight = 0.3;   // low 0.4
  person.height = 0.65;  // high 0.3
  const auto weights = weights_of(person);
  EXPECT_NEAR(weights.at("macrodetails/universal-male-old-maxmuscle-minweight"), 0.25 * 0.6 * 0.8 * 0.4,
              1e-12);
  EXPECT_NEAR(weights.at("macrodetails/height/female-young-averagemuscle-averageweight-maxheight"),
              0.75 * 0.4 * 0.2 * 0.6 * 0.3, 1e-12);
  EXPECT_FALSE(weights.contains("macrodetails/height/female-young-averagemuscle-averageweight-minheight"));
}

TEST(BodyShapeTest, FamiliesSumToOneForEveryone) {
  for (const double age : {0.1875, 0.3, 0.5, 0.75, 1.0}) {
    for (const double build : {0.0, 0.2, 0.5, 0.77, 1.0}) {
      PersonShape person;
      person.gender = 0.3;
      person.age = age;
      person.weight = build;
      person.muscle = 1.0 - build;
      person.african = 0.2;
      person.asian = 0.0;
      const auto weights = weights_of(person);
      EXPECT_NEAR(sum_of(weights, "macrodetails/universal"), 1.0, 1e-12);
      EXPECT_NEAR(sum_of(weights, "macrodetails/african") + sum_of(weights, "macrodetails/caucasian"), 1.0,
                  1e-12);
      EXPECT_EQ(sum_of(weights, "macrodetails/asian"), 0.0);
      EXPECT_EQ(sum_of(weights, "macrodetails/height"), 0.0);
    }
  }
}

TEST(BodyShapeTest, DetailsTakeTheTargetOfTheirSign) {
  PersonShape person;
  person.hand_scale = -0.4;
  person.forearm_fat = 0.7;
  const auto weights = weights_of(person);
  EXPECT_DOUBLE_EQ(weights.at("armslegs/r-hand-scale-decr"), 0.4);
  EXPECT_FALSE(weights.contains("armslegs/r-hand-scale-incr"));
  EXPECT_DOUBLE_EQ(weights.at("armslegs/r-lowerarm-fat"), 0.7);
}

TEST(BodyShapeTest, EveryTargetIsListedOnce) {
  const std::vector<std::string> names = person_target_names();
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  EXPECT_EQ(names.size(), 18u + 54u + 108u + 20u);
}

TEST(BodyShapeTest, BadValuesAreNamed) {
  PersonShape person;
  person.age = 0.1;
  EXPECT_THAT(error_of([&] { weighted_targets(person); }), HasSubstr("age"));
  person = PersonShape{};
  person.finger_length = 1.5;
  EXPECT_THAT(error_of([&] { weighted_targets(person); }), HasSubstr("finger_length"));
  person = PersonShape{};
  person.african = person.asian = person.caucasian = 0.0;
  EXPECT_THAT(error_of([&] { weighted_targets(person); }), HasSubstr("african"));
  EXPECT_THAT(error_of([&] { shape_coefficients(box_hand_body(), PersonShape{}); }),
              HasSubstr("macrodetails/"));
}

}  // namespace
}  // namespace knuckle
