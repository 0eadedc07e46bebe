// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people/people.h"

#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/synth/makehuman/makehuman_import.h"

namespace knuckle {
namespace {

struct Spread {
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;

  void add(double value) {
    sum += value;
    squares += value * value;
    ++count;
  }
  double mean() const { return sum / count; }
  double deviation() const { return std::sqrt(squares / count - mean() * mean()); }
};

TEST(People, AWiderPalmIsBroader) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) GTEST_SKIP() << "MakeHuman's data is not here";
  const Body body = makehuman_body(makehuman_folder());
  Person person;
  const double breadth = hand_breadth_mm(shaped_body(body, person));
  EXPECT_GT(breadth, 70.0);
  EXPECT_LT(breadth, 100.0);
  person.proportions.palm_breadth = 1.1;
  const double growth = hand_breadth_mm(shaped_body(body, person)) / breadth;
  EXPECT_GT(growth, 1.05);  // the skin of the knuckles belongs to the fingers, too
  EXPECT_LT(growth, 1.1);
  EXPECT_NEAR(hand_length_mm(shaped_body(body, person)), hand_length_mm(shaped_body(body, Person{})), 1.0);
}

/// Standard errors of 200 people of a sex: 0.7 mm (mean) and 0.5 mm (deviation) of the length, 0.3 and 0.2 mm
/// of the breadth; the bounds are about four of them.
TEST(People, HandsAreAsLongAndBroadAsSurveysFind) {
  if (!std::filesystem::exists(makehuman_folder() / "public")) GTEST_SKIP() << "MakeHuman's data is not here";
  const Body body = makehuman_body(makehuman_folder());
  std::array<Spread, 2> lengths;
  std::array<Spread, 2> breadths;
  Spread product;
  for (std::uint64_t i = 0; i < 400; ++i) {
    Random random(1, i);
    const Person person = sampled_person(body, 0.05, random);
    const ShapedBody shaped = shaped_body(body, person);
    const int sex = person.shape.gender > 0.5 ? 1 : 0;
    lengths[sex].add(hand_length_mm(shaped));
    breadths[sex].add(hand_breadth_mm(shaped));
    if (sex == 1) product.add((hand_length_mm(shaped) - 193.0) * (hand_breadth_mm(shaped) - 90.0));
  }
  EXPECT_NEAR(lengths[0].mean(), 181.0, 3.0);
  EXPECT_NEAR(lengths[1].mean(), 193.0, 3.0);
  EXPECT_NEAR(breadths[0].mean(), 79.0, 1.2);
  EXPECT_NEAR(breadths[1].mean(), 90.0, 1.2);
  for (const int sex : {0, 1}) {
    EXPECT_NEAR(lengths[sex].deviation(), 10.0, 2.0);
    EXPECT_NEAR(breadths[sex].deviation(), 4.0, 0.8);
  }
  EXPECT_NEAR(product.mean() / (10.0 * 4.0), 0.6, 0.2) << "correlation";
}

}  // namespace
}  // namespace knuckle
