// SPDX-License-Identifier: Apache-2.0
#include "knuckle/synth/makehuman/bone_heat.h"

#include <cmath>
#include <numbers>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

using ::knuckle::testing::error_of;
using ::testing::HasSubstr;

constexpr int kRings = 41;
constexpr int kSpokes = 12;
constexpr double kRadius = 8.0;
constexpr double kSpacing = 2.0;

struct Tube {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<std::int32_t, 3>> faces;
};

/// An open tube along z, 80 mm long.
Tube tube() {
  Tube result;
  for (int ring = 0; ring < kRings; ++ring) {
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const double angle = 2.0 * std::numbers::pi * spoke / kSpokes;
      result.vertices.emplace_back(kRadius * std::cos(angle), kRadius * std::sin(angle), kSpacing * ring);
      if (ring == kRings - 1) continue;
      const int a = ring * kSpokes + spoke;
      const int b = ring * kSpokes + (spoke + 1) % kSpokes;
      result.faces.push_back({a, b, b + kSpokes});
      result.faces.push_back({a, b + kSpokes, a + kSpokes});
    }
  }
  return result;
}

const std::vector<BoneSegment> kTwoBones{{{0, 0, 0}, {0, 0, 40}}, {{0, 0, 40}, {0, 0, 80}}};

TEST(BoneHeatTest, WeightsAreAPartitionOfOne) {
  const Tube skin = tube();
  const Eigen::MatrixXd weights = bone_heat_weights(skin.vertices, skin.faces, kTwoBones, 4.0);
  ASSERT_EQ(weights.rows(), kRings * kSpokes);
  EXPECT_LT((weights.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-9);
  EXPECT_GE(weights.minCoeff(), -1e-9);
}

TEST(BoneHeatTest, FallsOffAsTheHeatEquationOfATubeSays) {
  const Tube skin = tube();
  const double heat = 4.0;
  const Eigen::MatrixXd weights = bone_heat_weights(skin.vertices, skin.faces, kTwoBones, heat);
  const double decay_mm = kRadius / std::sqrt(heat);  // w'' = heat / r^2 (w - p)
  for (int ring = 5; ring < kRings - 5; ++ring) {
    const double from_joint = kSpacing * ring - 40.0;
    const double expected = from_joint <= 0.0 ? 0.5 * std::exp(from_joint / decay_mm)
                                              : 1.0 - 0.5 * std::exp(-from_joint / decay_mm);
    // The ring at the joint belongs to one bone whole: the step lies half a spacing off, and is smeared by as
    // much.
    EXPECT_NEAR(weights(ring * kSpokes + 3, 1), expected, 0.5 * 0.5 * kSpacing / decay_mm + 0.02)
        << from_joint;
  }
}

TEST(BoneHeatTest, MoreHeatMakesSharperTransitions) {
  const Tube skin = tube();
  const int ring_outwards = 23 * kSpokes;
  const double soft = bone_heat_weights(skin.vertices, skin.faces, kTwoBones, 1.0)(ring_outwards, 0);
  const double sharp = bone_heat_weights(skin.vertices, skin.faces, kTwoBones, 9.0)(ring_outwards, 0);
  EXPECT_LT(sharp, soft);
}

TEST(BoneHeatTest, BadInputIsNamed) {
  const Tube skin = tube();
  EXPECT_THAT(error_of([&] { bone_heat_weights(skin.vertices, skin.faces, {}, 1.0); }),
              HasSubstr("no bones"));
  EXPECT_THAT(error_of([&] { bone_heat_weights(skin.vertices, skin.faces, kTwoBones, 0.0); }),
              HasSubstr("heat is 0"));
  EXPECT_THAT(error_of([&] { bone_heat_weights(skin.vertices, skin.faces, kTwoBones, std::nan("")); }),
              HasSubstr("heat is nan"));
  Tube with_a_loose_vertex = skin;
  with_a_loose_vertex.vertices.emplace_back(0.0, 0.0, 90.0);
  EXPECT_THAT(error_of([&] {
                bone_heat_weights(with_a_loose_vertex.vertices, with_a_loose_vertex.faces, kTwoBones, 1.0);
              }),
              HasSubstr("a vertex has no face"));
}

}  // namespace
}  // namespace knuckle
