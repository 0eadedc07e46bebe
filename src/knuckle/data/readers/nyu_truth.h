// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "knuckle/core/pose.h"

namespace knuckle {

/// The truth of one view of the NYU set: `joint_uvd` of its joint_data.mat, a Matlab array of
/// views x frames x 36 x 3 (px, px, mm), of which the 14 evaluated joints are kept: 168 bytes per frame.
class NyuTruth {
 public:
  /// Reads the view's part of the array; `view` counts from 1. Throws an Error that names the file where it
  /// is missing, cut short, no Matlab file, lacks the array, or where that has another shape or type.
  NyuTruth(std::filesystem::path path, int view);

  /// Number of frames that the file labels.
  std::int64_t size() const { return frame_count_; }
  /// The pose of a frame; frames count from 0. Throws an Error where there is none.
  HandPose pose(std::int64_t frame) const;

 private:
  std::filesystem::path path_;
  std::int64_t frame_count_ = 0;
  std::vector<float> uvd_;  ///< frames x 14 x 3
};

}  // namespace knuckle
