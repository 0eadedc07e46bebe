// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/core/frame.h"
#include "knuckle/data/poses_file.h"

namespace knuckle {

/// What predictions are compared with.
struct Truth {
  PoseSequence sequence;                ///< joints may be missing: those are left out of every measure
  std::vector<Projection> projections;  ///< one per frame, or a single one for all frames
  std::vector<std::optional<HandSide>> sides = {};  ///< one per frame, or none where no frame knows its own
  std::vector<int> sequences = {};  ///< of each frame, as in Frame; none: all are of one sequence

  const Projection& projection(std::int64_t frame) const {
    return projections[projections.size() == 1 ? 0 : static_cast<std::size_t>(frame)];
  }
  /// A hand whose side is not known counts as a right one.
  HandSide side(std::int64_t frame) const {
    return sides.empty() ? HandSide::right : sides[static_cast<std::size_t>(frame)].value_or(HandSide::right);
  }
};

/// What a method predicted, one pose a frame of the truth.
struct Predictions {
  std::string name;  ///< of the method
  PoseSequence sequence;
};

/// Distances of the predicted joints from the true ones: the table that all measures are computed from.
///
/// A joint that the truth lacks is NaN: it is left out. A prediction that misses at least one of the joints
/// that the frame's truth has is a missing prediction: all joints of that frame are infinitely far off, so
/// the frame fails at every threshold, and none of it enters a mean or median.
struct JointErrors {
  std::vector<Landmark> joints;         ///< landmarks that both conventions hold, in the order of the truth's
  std::vector<Landmark> only_in_truth;  ///< dropped
  std::vector<Landmark> only_in_predictions;  ///< dropped
  std::int64_t frames = 0;
  std::vector<double> distance_3d_mm;  ///< frames x joints, NaN or infinite as said above
  std::vector<double> distance_2d_px;  ///< frames x joints

  std::span<const double> frame_3d_mm(std::int64_t frame) const { return frame_of(distance_3d_mm, frame); }
  std::span<const double> frame_2d_px(std::int64_t frame) const { return frame_of(distance_2d_px, frame); }

 private:
  std::span<const double> frame_of(const std::vector<double>& table, std::int64_t frame) const {
    return std::span(table).subspan(static_cast<std::size_t>(frame) * joints.size(), joints.size());
  }
};

/// Compares frame by frame, landmark by landmark: in the image, and in camera coordinates through the frame's
/// projection. `only`: these landmarks alone, which both conventions hold; none: all that both hold. Throws
/// an Error that names the predictions' file where its number of frames differs from the truth's, or the
/// conventions share no landmark, or the truth knows not one joint.
JointErrors joint_errors(const Truth& truth, const Predictions& predictions,
                         std::span<const Landmark> only = {});

}  // namespace knuckle
