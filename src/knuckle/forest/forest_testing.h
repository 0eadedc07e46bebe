// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"
#include "knuckle/forest/flat_trees.h"
#include "knuckle/forest/pixel_samples.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle::testing {

/// Rows of random features in [-3, 3) and targets that depend on some of them, with noise.
struct RandomRows {
  std::vector<std::vector<float>> features;
  std::vector<std::vector<float>> targets;

  RandomRows(int count, int feature_count, int target_count, std::uint64_t seed = 7) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      std::vector<float> row;
      for (int f = 0; f < feature_count; ++f) row.push_back(static_cast<float>(random.uniform(-3.0, 3.0)));
      std::vector<float> target;
      for (int t = 0; t < target_count; ++t) {
        const auto a = static_cast<std::size_t>(t % feature_count);
        const auto b = static_cast<std::size_t>((t * 7 + 3) % feature_count);
        target.push_back(row[a] - row[b] + static_cast<float>(random.uniform(-0.1, 0.1)));
      }
      features.push_back(row);
      targets.push_back(target);
    }
  }

  /// The rows as training samples, sample i at place[i].
  TrainingSamples samples_at(const std::vector<std::int64_t>& place) const {
    TrainingSamples samples(static_cast<std::int64_t>(features.size()), static_cast<int>(features[0].size()),
                            static_cast<int>(targets[0].size()));
    for (std::size_t i = 0; i < features.size(); ++i) samples.set(place[i], features[i], targets[i]);
    return samples;
  }

  TrainingSamples samples() const {
    std::vector<std::int64_t> place(features.size());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<std::int64_t>(i);
    return samples_at(place);
  }
};

/// A depth image of balls before a slanted wall with holes; class 1 is a ball.
struct BallScene {
  Image<float> depth_mm;
  Camera camera;
  std::vector<LabelledPixel> pixels;

  explicit BallScene(std::uint64_t seed, int width = 61, int height = 47, int pixels_per_class = 40)
      : depth_mm(width, height),
        camera{.width = width, .height = height, .fx = 60.0, .fy = -58.0, .cx = 30.0, .cy = 22.0} {
    Random random(seed);
    const double x = random.uniform(0.2, 0.8) * width;
    const double y = random.uniform(0.2, 0.8) * height;
    const double distance = random.uniform(500.0, 900.0);
    const double radius = 60.0 * 80.0 / distance;
    std::vector<LabelledPixel> of_class[2];
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        const double inside = 1.0 - (std::pow(column - x, 2.0) + std::pow(row - y, 2.0)) / (radius * radius);
        const bool is_ball = inside > 0.0;
        const double depth = is_ball ? distance - 50.0 * std::sqrt(inside) : 1000.0 + 4.0 * column;
        if (!is_ball && random.uniform() < 0.3) continue;
        depth_mm(column, row) = static_cast<float>(depth + random.uniform(-3.0, 3.0));
        of_class[is_ball ? 1 : 0].push_back({static_cast<std::int16_t>(column),
                                             static_cast<std::int16_t>(row),
                                             static_cast<std::uint8_t>(is_ball ? 1 : 0)});
      }
    }
    for (const std::vector<LabelledPixel>& all : of_class) {
      for (int i = 0; i < pixels_per_class && !all.empty(); ++i) {
        pixels.push_back(all[random.below(static_cast<std::uint32_t>(all.size()))]);
      }
    }
  }
};

inline std::vector<BallScene> ball_scenes(int count) {
  std::vector<BallScene> scenes;
  for (int i = 0; i < count; ++i) scenes.emplace_back(static_cast<std::uint64_t>(i));
  return scenes;
}

/// The scenes as training samples, scene i at place[i] (or i where `place` is empty).
inline PixelSamples samples_of(const std::vector<BallScene>& scenes,
                               const std::vector<std::int64_t>& place = {}) {
  PixelSamples samples(std::ssize(scenes));
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    samples.set(place.empty() ? static_cast<std::int64_t>(i) : place[i], scenes[i].depth_mm, scenes[i].camera,
                scenes[i].pixels);
  }
  return samples;
}

template <class Feature>
void expect_same_trees(const FlatTrees<Feature>& a, const FlatTrees<Feature>& b) {
  ASSERT_EQ(a.roots, b.roots);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    const auto& x = a.nodes[i];
    const auto& y = b.nodes[i];
    ASSERT_TRUE(x.next == y.next && x.feature == y.feature && x.threshold == y.threshold) << i;
  }
}

}  // namespace knuckle::testing
