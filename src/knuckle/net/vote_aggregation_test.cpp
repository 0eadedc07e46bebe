// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/vote_aggregation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/patch/cube_patch.h"

namespace knuckle {
namespace {

constexpr int kSize = 32;
constexpr int kCells = kSize / 4;
constexpr int kJoints = 5;
constexpr double kKernel = 0.8;

/// The maps of a network, which tells sides and hands or not.
DenseMaps maps_of(bool tells_side, bool tells_hand) {
  DenseMaps maps{NetworkOptions{}};
  maps.count = 5 * kJoints;
  if (tells_side) maps.side = maps.count++;
  if (tells_hand) maps.hand = maps.count++;
  return maps;
}
DenseMaps of_joints() {
  return maps_of(false, false);
}

double centre_of(int cell) {
  const double half = 0.5 * (kSize - 1);
  return (4 * cell + 1.5 - half) / half;
}

Image<float> half_empty_patch() {
  Image<float> patch(kSize, kSize, kCubeBackground);
  Random random(1);
  for (int row = 6; row < 22; ++row) {
    for (int column = 3; column < 29; ++column) {
      if (random.uniform() < 0.4) patch(column, row) = static_cast<float>(random.uniform(-0.9, 0.9));
    }
  }
  return patch;
}

double nearest(const Image<float>& patch, int row, int column) {
  double depth = kCubeBackground;
  for (int k = 0; k < 16; ++k) {
    depth = std::min<double>(depth, patch(4 * column + k % 4, 4 * row + k / 4));
  }
  return depth;
}

FeatureMap random_votes() {
  FeatureMap votes({kCells, kCells, 5 * kJoints});
  Random random(2);
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      for (int i = 0; i < 5 * kJoints; ++i) {
        const double spread = i < 4 * kJoints ? 1.0 : 20.0;  // weights are of very different size
        votes.pixel(row, column)[i] = static_cast<float>(spread * random.normal());
      }
    }
  }
  return votes;
}

struct Vote {
  double u, v, d, weight;
};

/// By the definition: the votes of one joint, their weights those of a softmax.
std::vector<Vote> votes_of(const FeatureMap& maps, const Image<float>& patch, int joint, bool only_hand) {
  std::vector<Vote> votes;
  double sum = 0.0;
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const double depth = nearest(patch, row, column);
      if (only_hand && depth >= kCubeBackground) continue;
      const float* const at = maps.pixel(row, column) + joint;
      const double reach = (1.0 - at[3 * kJoints]) * kKernel;
      votes.push_back({centre_of(column) + at[0] * reach, centre_of(row) + at[kJoints] * reach,
                       depth + at[2 * kJoints] * reach, std::exp(static_cast<double>(at[4 * kJoints]))});
      sum += votes.back().weight;
    }
  }
  for (Vote& vote : votes) vote.weight /= sum;
  return votes;
}

void expect_definition(const Image<float>& patch, bool only_hand) {
  const FeatureMap maps = random_votes();
  const NetworkPrediction found = aggregate_votes(maps, patch, kJoints, of_joints(), kKernel);
  ASSERT_EQ(found.joints.size(), static_cast<std::size_t>(kJoints));
  for (int j = 0; j < kJoints; ++j) {
    const std::vector<Vote> votes = votes_of(maps, patch, j, only_hand);
    Vote mean{};
    for (const Vote& vote : votes) {
      mean.u += vote.weight * vote.u;
      mean.v += vote.weight * vote.v;
      mean.d += vote.weight * vote.d;
    }
    double squares = 0.0;
    for (const Vote& vote : votes) {
      squares += vote.weight *
                 (std::pow(vote.u - mean.u, 2) + std::pow(vote.v - mean.v, 2) + std::pow(vote.d - mean.d, 2));
    }
    EXPECT_NEAR(found.joints[j].u, mean.u, 1e-5);
    EXPECT_NEAR(found.joints[j].v, mean.v, 1e-5);
    EXPECT_NEAR(found.joints[j].d, mean.d, 1e-5);
    EXPECT_NEAR(found.confidence[j], std::exp(-std::sqrt(squares) / 0.15), 1e-5);
  }
}

TEST(VoteAggregation, IsTheMeanOfTheHandsVotes) {
  expect_definition(half_empty_patch(), true);
}

TEST(VoteAggregation, OfNothingButBackgroundAllCellsVote) {
  expect_definition(Image<float>(kSize, kSize, kCubeBackground), false);
}

TEST(VoteAggregation, FindsTheJointsThatTrueVotesPointAt) {
  const Image<float> patch = half_empty_patch();
  FeatureMap maps = random_votes();
  const std::vector<PatchPoint> joints = {
      {0.1, 0.2, 0.3}, {-0.4, 0.0, 0.1}, {0.5, -0.5, -0.2}, {0.0, 0.0, 0.0}, {0.3, 0.3, -0.6}};
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      for (int j = 0; j < kJoints; ++j) {
        const double u = joints[j].u - centre_of(column);
        const double v = joints[j].v - centre_of(row);
        const double d = joints[j].d - nearest(patch, row, column);
        const double distance = std::sqrt(u * u + v * v + d * d);
        float* const at = maps.pixel(row, column) + j;
        at[0] = static_cast<float>(u / distance);
        at[kJoints] = static_cast<float>(v / distance);
        at[2 * kJoints] = static_cast<float>(d / distance);
        at[3 * kJoints] = static_cast<float>(1.0 - distance / kKernel);
      }
    }
  }
  const NetworkPrediction found = aggregate_votes(maps, patch, kJoints, of_joints(), kKernel);
  for (int j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(found.joints[j].u, joints[j].u, 1e-5);
    EXPECT_NEAR(found.joints[j].v, joints[j].v, 1e-5);
    EXPECT_NEAR(found.joints[j].d, joints[j].d, 1e-5);
    EXPECT_NEAR(found.confidence[j], 1.0f, 1e-4);
  }
}

TEST(VoteAggregation, TheMapsOfSidesAndHandsAreLogits) {
  const Image<float> patch = half_empty_patch();
  FeatureMap maps({kCells, kCells, 5 * kJoints + 2});
  double sums[2] = {};
  int voters = 0;
  Random random(3);
  for (int row = 0; row < kCells; ++row) {
    for (int column = 0; column < kCells; ++column) {
      const bool votes = nearest(patch, row, column) < kCubeBackground;
      for (int i = 0; i < 2; ++i) {
        float& logit = maps.pixel(row, column)[5 * kJoints + i];
        logit = static_cast<float>((i == 0 ? 1.0 : -2.0) + random.normal());
        if (votes) sums[i] += logit;
      }
      voters += votes ? 1 : 0;
    }
  }
  const auto logistic = [&](double sum) { return 1.0 / (1.0 + std::exp(-sum / voters)); };
  const auto seen = [&](bool tells_side, bool tells_hand) {
    return aggregate_votes(maps, patch, kJoints, maps_of(tells_side, tells_hand), kKernel);
  };
  ASSERT_GT(sums[0] / voters, 0.2);
  ASSERT_LT(sums[1] / voters, -0.2);
  EXPECT_NEAR(seen(true, true).right_hand.value(), logistic(sums[0]), 1e-6);
  EXPECT_NEAR(seen(true, true).hand.value(), logistic(sums[1]), 1e-6);
  EXPECT_NEAR(seen(true, false).right_hand.value(), logistic(sums[0]), 1e-6);
  EXPECT_NEAR(seen(false, true).hand.value(), logistic(sums[0]), 1e-6) << "then it is the first of them";
  EXPECT_FALSE(seen(false, true).right_hand);
  EXPECT_FALSE(seen(true, false).hand);
}

}  // namespace
}  // namespace knuckle
