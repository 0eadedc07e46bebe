// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks.
#pragma once

#include "knuckle/core/image.h"
#include "knuckle/net/layers/feature_map.h"

namespace knuckle {

/// Writes a square image into a map made by `FeatureMap::of_image`.
void copy_image(const Image<float>& image, FeatureMap& map);

/// Adds a map of half the size to `fine`, each of its pixels four times.
void add_twice_as_large(const FeatureMap& coarse, FeatureMap& fine);

/// The largest of each `size` x `size` pixels, channel by channel; what is left over at the right and below
/// is not seen.
void max_pool(const FeatureMap& input, int size, FeatureMap& output);

/// The mean of each 2 x 2 pixels.
void halve(const FeatureMap& input, FeatureMap& output);

}  // namespace knuckle
