// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "knuckle/core/statistics.h"
#include "knuckle/data/truth.h"

namespace knuckle {
namespace {

using Points = std::vector<Point3>;  // NaN where not known

/// The landmarks of a pose that both conventions have, in the order of the truth's.
Points shared(const Points& points, const std::vector<int>& places) {
  Points kept;
  for (const int place : places) kept.push_back(points[static_cast<std::size_t>(place)]);
  return kept;
}

/// Truth and estimates of all frames in camera coordinates, landmark by landmark the same.
struct Motion {
  std::vector<Points> truth;
  std::vector<Points> estimate;
  std::vector<int> sequence;

  std::int64_t size() const { return std::ssize(truth); }
  std::size_t joints() const { return truth.empty() ? 0 : truth.front().size(); }
  /// Whether the frames [first, last] are of one sequence.
  bool is_one_sequence(std::int64_t first, std::int64_t last) const {
    return first >= 0 && last < size() && sequence[first] == sequence[last];
  }
};

Motion motion_of(const Truth& truth, const Predictions& predictions) {
  const ConventionMapping mapping =
      map_convention(predictions.sequence.convention, truth.sequence.convention);
  std::vector<int> in_truth;
  std::vector<int> in_predictions;
  for (std::size_t j = 0; j < mapping.source_index.size(); ++j) {
    if (mapping.source_index[j] < 0) continue;
    in_truth.push_back(static_cast<int>(j));
    in_predictions.push_back(mapping.source_index[j]);
  }
  Motion motion;
  const std::size_t count = truth.sequence.poses.size();
  motion.sequence = truth.sequences.empty() ? std::vector<int>(count, 0) : truth.sequences;
  for (std::size_t i = 0; i < count; ++i) {
    const Projection& projection = truth.projection(static_cast<std::int64_t>(i));
    motion.truth.push_back(shared(points_in_camera(truth.sequence.poses[i], projection), in_truth));
    motion.estimate.push_back(
        shared(points_in_camera(predictions.sequence.poses[i], projection), in_predictions));
  }
  return motion;
}

/// The second difference of a landmark around a frame; NaN where one of the three is not known.
Point3 acceleration(const std::vector<Points>& points, std::int64_t frame, std::size_t joint) {
  return points[frame + 1][joint] - 2.0 * points[frame][joint] + points[frame - 1][joint];
}

void score_acceleration(const Motion& motion, MotionScore& score) {
  RunningMean estimated;
  RunningMean truth;
  RunningMean error;
  for (std::int64_t frame = 1; frame + 1 < motion.size(); ++frame) {
    if (!motion.is_one_sequence(frame - 1, frame + 1)) continue;
    const std::int64_t before = error.count;
    for (std::size_t joint = 0; joint < motion.joints(); ++joint) {
      const Point3 of_estimate = acceleration(motion.estimate, frame, joint);
      const Point3 of_truth = acceleration(motion.truth, frame, joint);
      if (!of_estimate.allFinite() || !of_truth.allFinite()) continue;
      estimated.add(of_estimate.norm());
      truth.add(of_truth.norm());
      error.add((of_estimate - of_truth).norm());
    }
    score.frames += error.count > before ? 1 : 0;
  }
  score.acceleration_mm = estimated.value();
  score.true_acceleration_mm = truth.value();
  score.acceleration_error_mm = error.value();
}

/// RunningMean squared distance of the truth from the estimates `shift` frames later.
double squared_distance(const Motion& motion, int shift) {
  RunningMean mean;
  for (std::int64_t frame = 0; frame < motion.size(); ++frame) {
    const std::int64_t later = frame + shift;
    if (!motion.is_one_sequence(std::min(frame, later), std::max(frame, later))) continue;
    for (std::size_t joint = 0; joint < motion.joints(); ++joint) {
      const double square = (motion.estimate[later][joint] - motion.truth[frame][joint]).squaredNorm();
      if (std::isfinite(square)) mean.add(square);
    }
  }
  return mean.value();
}

/// How far true joints move from frame to frame, on average.
double true_speed(const Motion& motion) {
  RunningMean mean;
  for (std::int64_t frame = 1; frame < motion.size(); ++frame) {
    if (!motion.is_one_sequence(frame - 1, frame)) continue;
    for (std::size_t joint = 0; joint < motion.joints(); ++joint) {
      const double moved = (motion.truth[frame][joint] - motion.truth[frame - 1][joint]).norm();
      if (std::isfinite(moved)) mean.add(moved);
    }
  }
  return mean.value();
}

double lag_of(const Motion& motion) {
  std::array<double, 2 * kMostLagFrames + 1> distances;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    distances[i] = squared_distance(motion, static_cast<int>(i) - kMostLagFrames);
    if (std::isnan(distances[i])) return kNaN;
  }
  const auto least = std::ranges::min_element(distances) - distances.begin();
  const auto lag = static_cast<double>(least - kMostLagFrames);
  if (least == 0 || least + 1 == std::ssize(distances)) return lag;
  const double before = distances[static_cast<std::size_t>(least - 1)];
  const double here = distances[static_cast<std::size_t>(least)];
  const double after = distances[static_cast<std::size_t>(least + 1)];
  const double curvature = before - 2.0 * here + after;
  return curvature > 0.0 ? lag + 0.5 * (before - after) / curvature : lag;
}

/// Whether no true joint moves from the frame before to this one.
bool stands_still(const Motion& motion, std::int64_t frame) {
  if (!motion.is_one_sequence(frame - 1, frame)) return false;
  bool is_known = false;
  for (std::size_t joint = 0; joint < motion.joints(); ++joint) {
    const double moved = (motion.truth[frame][joint] - motion.truth[frame - 1][joint]).norm();
    if (moved >= kStillMm) return false;
    is_known = is_known || std::isfinite(moved);
  }
  return is_known;
}

/// Deviation of one landmark's estimates from their mean over the frames [first, end).
std::optional<double> deviation(const Motion& motion, std::int64_t first, std::int64_t end,
                                std::size_t joint) {
  Point3 mean = Point3::Zero();
  std::int64_t count = 0;
  for (std::int64_t frame = first; frame < end; ++frame) {
    const Point3& point = motion.estimate[frame][joint];
    if (!point.allFinite()) continue;
    mean += point;
    ++count;
  }
  if (count < kStillFrames) return std::nullopt;
  mean /= static_cast<double>(count);
  RunningMean squares;
  for (std::int64_t frame = first; frame < end; ++frame) {
    const double square = (motion.estimate[frame][joint] - mean).squaredNorm();
    if (std::isfinite(square)) squares.add(square);
  }
  return std::sqrt(squares.value());
}

void score_jitter(const Motion& motion, MotionScore& score) {
  std::vector<RunningMean> of_joints(motion.joints());
  std::int64_t first = 0;
  for (std::int64_t frame = 1; frame <= motion.size(); ++frame) {
    if (frame < motion.size() && stands_still(motion, frame)) continue;
    for (std::size_t joint = 0; frame - first >= kStillFrames && joint < motion.joints(); ++joint) {
      if (const auto jitter = deviation(motion, first, frame, joint)) of_joints[joint].add(*jitter);
    }
    first = frame;
  }
  RunningMean all;
  for (const RunningMean& of_joint : of_joints) {
    if (of_joint.count == 0) continue;
    all.add(of_joint.value());
    score.worst_jitter_mm = std::isnan(score.worst_jitter_mm)
                                ? of_joint.value()
                                : std::max(score.worst_jitter_mm, of_joint.value());
  }
  score.jitter_mm = all.value();
}

/// The relative deviation of a bone's length over the frames [first, end); nothing where fewer than two know
/// it.
std::optional<double> length_deviation(const Predictions& predictions, const Truth& truth, const Bone& bone,
                                       std::int64_t first, std::int64_t end) {
  std::vector<double> lengths;
  for (std::int64_t frame = first; frame < end; ++frame) {
    const HandPose& pose = predictions.sequence.poses[static_cast<std::size_t>(frame)];
    const ImagePoint& from = pose.joints[static_cast<std::size_t>(bone.from)];
    const ImagePoint& to = pose.joints[static_cast<std::size_t>(bone.to)];
    if (from.is_missing() || to.is_missing()) continue;
    const Projection& projection = truth.projection(frame);
    lengths.push_back((projection.to_camera(from) - projection.to_camera(to)).norm());
  }
  if (lengths.size() < 2) return std::nullopt;
  RunningMean mean;
  for (const double length : lengths) mean.add(length);
  RunningMean squares;
  for (const double length : lengths) squares.add((length - mean.value()) * (length - mean.value()));
  if (!(mean.value() > 0.0)) return std::nullopt;
  return std::sqrt(squares.value()) / mean.value();
}

double bone_deviation(const Motion& motion, const Predictions& predictions, const Truth& truth) {
  RunningMean mean;
  const std::vector<Bone> bones = skeleton_of(predictions.sequence.convention);
  std::int64_t first = 0;
  for (std::int64_t frame = 1; frame <= motion.size(); ++frame) {
    if (frame < motion.size() && motion.is_one_sequence(frame - 1, frame)) continue;
    for (const Bone& bone : bones) {
      if (const auto part = length_deviation(predictions, truth, bone, first, frame)) mean.add(*part);
    }
    first = frame;
  }
  return mean.value();
}

}  // namespace

MotionScore motion_score(const Truth& truth, const Predictions& predictions) {
  const Motion motion = motion_of(truth, predictions);
  MotionScore score;
  const double speed = true_speed(motion);
  if (!(speed <= kUnrelatedMm)) return score;
  score_acceleration(motion, score);
  if (speed >= kMovingMm) score.lag_frames = lag_of(motion);
  score_jitter(motion, score);
  score.bone_deviation = bone_deviation(motion, predictions, truth);
  return score;
}

}  // namespace knuckle
