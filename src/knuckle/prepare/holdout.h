// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "knuckle/data/frame_source.h"

namespace knuckle {

/// Frames of a source that are kept from training, for validation. They are whole sequences: neighbours of a
/// sequence are nearly the same frame, and a network that has seen the one knows the other.
struct Holdout {
  double share = 0.0;  ///< of the source's frames, [0, 0.9]; 0: nothing is held out
  enum class Part { training, validation } part = Part::training;  ///< which of the two is taken
};

/// The frames of that part, rising; all of them where nothing is held out. Which sequences are held out hangs
/// on the source's sequences and `share` alone, so that trainings can be compared: in a random order, which
/// is always the same, those that bring their number of frames nearer to the share. At least one sequence is
/// in each part. Throws an Error that starts with `name` where the source is all one sequence.
std::vector<std::int64_t> frames_of_part(const FrameSource& source, const Holdout& holdout,
                                         std::string_view name);

}  // namespace knuckle
