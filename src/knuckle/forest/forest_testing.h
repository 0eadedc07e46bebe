// SPDX-License-Identifier: Apache-2.0
// Helpers for tests only; not part of the library.
#pragma once

#include <cstddef>
#include <vector>

#include "knuckle/core/random.h"
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

}  // namespace knuckle::testing
