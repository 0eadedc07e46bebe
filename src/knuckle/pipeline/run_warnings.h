// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/pipeline/pipeline.h"

namespace knuckle {

/// What is probably wrong with a source, from what a pipeline saw in its frames: mistakes in units and
/// intrinsics make no frame fail and all results wrong. Safe to call from many threads; the messages do not
/// depend on the order of the frames (where these have one camera).
class RunWarnings {
 public:
  /// Takes note of a frame and of what was found in it.
  void add(const Frame& frame, const FrameEstimate& estimate);

  /// One line per suspicion: what was found, what was expected, what to check. Only what holds for most
  /// frames is told; none where all is well.
  std::vector<std::string> messages() const;

 private:
  void add_camera(const Camera& camera);
  void add_distance(double distance_mm);

  mutable std::mutex mutex_;
  std::int64_t frames_ = 0;
  std::int64_t frames_without_sure_hand_ = 0;
  std::int64_t frames_with_distance_ = 0;
  std::int64_t near_frames_ = 0;
  std::int64_t far_frames_ = 0;
  double nearest_mm_ = std::numeric_limits<double>::infinity();
  double farthest_mm_ = 0.0;
  std::int64_t odd_cameras_ = 0;
  Camera odd_camera_;  // the first of them
};

}  // namespace knuckle
