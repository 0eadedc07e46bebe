// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/data/readers/h5_facts.h"
#include "knuckle/data/readers/stored_frame.h"

namespace knuckle {

// The sums of a frame in a Knuckle dataset, by which damage is noticed. They are taken of values, not of the
// file's bytes: who packs the set in another way leaves them right. Each value goes through XXH3 (64 bits,
// little-endian) with the sum of those before it as the seed.

/// Of what a set says of all its frames, and what therefore changes with none of them: unit of depth, kind,
/// size and distortion of the camera, manifest, generator, the whole set.
std::uint64_t sum_of_facts(const H5Facts& facts);

/// Of all of a frame but its images: its number in the whole set, intrinsics, side, time, sequence, joints
/// and hands; of another set's frame it is another.
std::uint64_t sum_of_numbers(const StoredFrame& frame, std::int64_t number, std::uint64_t facts);

/// Of the pixels, and of which images there are.
std::uint64_t sum_of_images(const StoredImages& images);

}  // namespace knuckle
