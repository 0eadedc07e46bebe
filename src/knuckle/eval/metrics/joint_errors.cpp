// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/joint_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "knuckle/core/error.h"
#include "knuckle/core/text.h"

namespace knuckle {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A pair of places of one landmark: in the truth's convention and in the predictions'.
struct JointPair {
  int in_truth;
  int in_predictions;
};

std::vector<JointPair> joint_pairs(const Convention& truth, const Convention& predictions,
                                   std::span<const Landmark> landmarks) {
  std::vector<JointPair> pairs;
  for (const Landmark landmark : landmarks)
    pairs.push_back({truth.index_of(landmark), predictions.index_of(landmark)});
  return pairs;
}

void check_comparable(const Truth& truth, const Predictions& predictions, const ConventionMapping& mapping) {
  const PoseSequence& expected = truth.sequence;
  const PoseSequence& found = predictions.sequence;
  if (found.poses.size() != expected.poses.size()) {
    fail("{}: {} frames predicted, but the truth {} has {}", found.origin, found.poses.size(),
         expected.origin, expected.poses.size());
  }
  if (mapping.shared.empty()) {
    fail("{}: its convention {} shares no landmark with the truth's, {}", found.origin, found.convention.name,
         expected.convention.name);
  }
  if (truth.projections.size() != 1 && truth.projections.size() != expected.poses.size()) {
    fail("{}: expected one camera, or one for each of {} frames, found {}", expected.origin,
         expected.poses.size(), truth.projections.size());
  }
}

/// Fills one frame's rows of both tables.
class FrameComparison {
 public:
  FrameComparison(const std::vector<JointPair>& pairs, const Projection& projection)
      : pairs_(pairs), projection_(projection) {}

  void compare(const HandPose& truth, const HandPose& predicted, double* distance_3d_mm,
               double* distance_2d_px) const {
    bool is_missing = false;
    for (std::size_t j = 0; j < pairs_.size(); ++j) {
      const ImagePoint& expected = truth.joints[pairs_[j].in_truth];
      const ImagePoint& found = predicted.joints[pairs_[j].in_predictions];
      distance_3d_mm[j] = distance_2d_px[j] = kNaN;
      if (expected.is_missing()) continue;
      distance_3d_mm[j] = (projection_.to_camera(found) - projection_.to_camera(expected)).norm();
      distance_2d_px[j] = std::hypot(found.u - expected.u, found.v - expected.v);
      is_missing |= found.is_missing() || !std::isfinite(distance_3d_mm[j]);
    }
    if (is_missing) mark_missing(truth, distance_3d_mm, distance_2d_px);
  }

 private:
  void mark_missing(const HandPose& truth, double* distance_3d_mm, double* distance_2d_px) const {
    for (std::size_t j = 0; j < pairs_.size(); ++j) {
      if (truth.joints[pairs_[j].in_truth].is_missing()) continue;
      distance_3d_mm[j] = distance_2d_px[j] = kInfinity;
    }
  }

  const std::vector<JointPair>& pairs_;
  const Projection& projection_;
};

}  // namespace

JointErrors joint_errors(const Truth& truth, const Predictions& predictions, std::span<const Landmark> only) {
  const Convention& convention = truth.sequence.convention;
  const ConventionMapping mapping = map_convention(predictions.sequence.convention, convention);
  check_comparable(truth, predictions, mapping);
  std::vector<Landmark> compared(only.begin(), only.end());
  if (only.empty()) compared = mapping.shared;
  const std::vector<JointPair> pairs = joint_pairs(convention, predictions.sequence.convention, compared);

  JointErrors errors{std::move(compared), mapping.missing, mapping.dropped, 0, {}, {}};
  errors.frames = static_cast<std::int64_t>(truth.sequence.poses.size());
  errors.distance_3d_mm.resize(truth.sequence.poses.size() * pairs.size());
  errors.distance_2d_px.resize(errors.distance_3d_mm.size());
  for (std::int64_t frame = 0; frame < errors.frames; ++frame) {
    const std::size_t row = static_cast<std::size_t>(frame) * pairs.size();
    FrameComparison(pairs, truth.projection(frame))
        .compare(truth.sequence.poses[frame], predictions.sequence.poses[frame], &errors.distance_3d_mm[row],
                 &errors.distance_2d_px[row]);
  }
  if (std::ranges::all_of(errors.distance_3d_mm, [](double distance) { return std::isnan(distance); })) {
    fail("{}: the truth holds no known joint that {} predicts", truth.sequence.origin, predictions.name);
  }
  return errors;
}

}  // namespace knuckle
