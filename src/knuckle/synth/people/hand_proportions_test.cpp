// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/people/hand_proportions.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/testing.h"
#include "knuckle/hand/testing_body.h"

namespace knuckle {
namespace {

using Eigen::Vector3f;

class HandProportionsTest : public ::testing::Test {
 protected:
  double bone_length(const ShapedBody& person, int finger, int part) const {
    const int first = static_cast<int>(Landmark::thumb_cmc) + 4 * finger + part;
    return (person.landmarks[first + 1] - person.landmarks[first]).norm();
  }

  Body body_ = testing::box_hand_body();
  ShapedBody person_ = shaped_body(body_, std::vector<double>(body_.shapedirs.size(), 0.0));
};

TEST_F(HandProportionsTest, FactorsOfOneChangeNothing) {
  const ShapedBody same = with_proportions(person_, {});
  for (std::size_t i = 0; i < same.vertices.size(); ++i) {
    EXPECT_TRUE(same.vertices[i].isApprox(person_.vertices[i], 1e-5f)) << i;
  }
}

TEST_F(HandProportionsTest, EachBoneIsAsLongAsItsFactorSays) {
  Random random(1);
  for (int repetition = 0; repetition < 20; ++repetition) {
    const HandProportions proportions = sampled_proportions(0.1, random);
    const ShapedBody changed = with_proportions(person_, proportions);
    for (int finger = 0; finger < kFingers; ++finger) {
      for (int part = 0; part < 3; ++part) {
        // The test body's markers lie half and half on two bones: their mean is exact where bones meet.
        EXPECT_NEAR(bone_length(changed, finger, part) / bone_length(person_, finger, part),
                    proportions.bone_lengths[finger][part], 1e-3)
            << finger << " " << part;
      }
    }
  }
}

TEST_F(HandProportionsTest, ThePalmGrowsFromTheWrist) {
  const ShapedBody changed = with_proportions(person_, {.palm_length = 1.2, .palm_breadth = 0.9});
  const auto at = [](const ShapedBody& person, Landmark which) {
    return person.landmarks[static_cast<std::size_t>(which)];
  };
  EXPECT_TRUE(at(changed, Landmark::wrist).isApprox(at(person_, Landmark::wrist), 1e-4f) ||
              at(changed, Landmark::wrist).norm() < 1e-3f);
  const Vector3f before = at(person_, Landmark::index_mcp) - at(person_, Landmark::little_mcp);
  const Vector3f after = at(changed, Landmark::index_mcp) - at(changed, Landmark::little_mcp);
  EXPECT_NEAR(after.norm() / before.norm(), 0.9, 0.01);  // its knuckles lie a little aslant
  EXPECT_NEAR(at(changed, Landmark::middle_mcp).y() / at(person_, Landmark::middle_mcp).y(), 1.2, 0.01);
  EXPECT_NEAR(bone_length(changed, 2, 0), bone_length(person_, 2, 0), 1e-3);
}

TEST_F(HandProportionsTest, TheForearmStaysWhereItIs) {
  HandProportions proportions;
  proportions.palm_length = 1.2;
  const ShapedBody changed = with_proportions(person_, proportions);
  for (std::size_t i = 0; i < person_.vertices.size(); ++i) {
    if (person_.vertices[i].y() > 1.0f) {
      EXPECT_EQ(changed.vertices[i], person_.vertices[i]);
    }
  }
}

TEST_F(HandProportionsTest, WithoutSkinAHandHasNoBreadth) {
  EXPECT_GT(hand_breadth_mm(person_), 40.0);
  Body bare = body_;
  std::ranges::fill(bare.is_hand, std::uint8_t{0});
  const ShapedBody person = shaped_body(bare, std::vector<double>(bare.shapedirs.size(), 0.0));
  EXPECT_THAT(testing::error_of([&] { hand_breadth_mm(person); }),
              ::testing::HasSubstr("the knuckles have no skin"));
}

TEST_F(HandProportionsTest, ProportionsSpreadAsAskedFor) {
  Random random(5);
  double sum = 0.0;
  double squares = 0.0;
  constexpr int kCount = 4000;
  for (int i = 0; i < kCount; ++i) {
    const double length = sampled_proportions(0.05, random).bone_lengths[3][1] - 1.0;
    sum += length;
    squares += length * length;
  }
  EXPECT_NEAR(sum / kCount, 0.0, 0.004);
  EXPECT_NEAR(std::sqrt(squares / kCount), 0.05 * std::sqrt(1.0 + 0.49), 0.004);
}

}  // namespace
}  // namespace knuckle
