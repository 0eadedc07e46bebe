// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/hand/landmark_definition.h"
#include "knuckle/pipeline/hand_finder.h"
#include "knuckle/pipeline/start.h"
#include "knuckle/prepare/cube_samples.h"
#include "knuckle/prepare/holdout.h"

namespace knuckle {

/// What became of the frames of a source of samples.
struct SampleFrames {
  std::int64_t total = 0;
  std::int64_t without_hand = 0;  ///< segmentation found none, also from the truth
  std::int64_t off_centre = 0;    ///< found elsewhere than the joints are
  std::int64_t used() const { return total - without_hand - off_centre; }
  void add(const SampleFrames& other) {
    total += other.total;
    without_hand += other.without_hand;
    off_centre += other.off_centre;
  }
};

/// Samples, and what became of the frames that they were cut from.
struct NetworkSamples {
  CubeSamples samples;
  SampleFrames frames;
};

/// How samples are cut out of frames.
struct SampleOptions {
  Convention convention = superset_convention();
  /// Where the convention's landmarks lie, for sources that have all 22 but not its own; nothing: landmarks
  /// are found by their names alone.
  std::optional<LandmarkDefinition> definition = {};
  Cube patch;
  int crop_px = 144;  ///< at least the patch's size
  Start start = Start::nearest;
  bool around_joints = false;  ///< around the mean of the true joints; segmentation is not asked
  std::int64_t most = 0;       ///< frames taken of the source at most, evenly spread; 0: all
  /// Which hands the source shows, where its frames do not say; nothing: as the finder's `[hand]` has it.
  std::optional<HandSide> side = {};
  Holdout holdout = {};  ///< which part of the frames is taken
};

/// Landmarks are found by their names: what a source does not label is not known in its samples; where it
/// labels all 22 and none of one's own, the definition says where these lie. Throws an Error that starts with
/// `name` where the source has no truth, or none of the convention's landmarks.
void require_landmarks(const FrameSource& source, const SampleOptions& options, std::string_view name);

/// The frames of a source that the options ask for: a part of it, and of this `most`, rising. Errors start
/// with `name`.
std::vector<std::int64_t> frames_for_samples(const FrameSource& source, const SampleOptions& options,
                                             std::string_view name);

/// Throws an Error that names the source where no frame of it could be used.
void require_used(const SampleFrames& frames, std::string_view source);

/// Cuts the hands out of a source's frames as a pipeline does at run time: around the centre that
/// segmentation finds, or around the true joints where it is to be trained for one that others find. Where it
/// starts at the nearest point and ends elsewhere than at the hand, it starts again at the truth. Frames
/// whose joints' mean is still more than 80 mm from the centre are left out. On all threads. Throws an Error
/// where the source has no truth, shares no landmark with the convention, or no frame of it can be used.
NetworkSamples network_samples(const std::string& source, const HandFinder& finder,
                               const SampleOptions& options);

}  // namespace knuckle
