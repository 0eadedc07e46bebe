// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/coordinate_check.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr std::int64_t kFramesLookedAt = 100;
constexpr double kClearlyBetter = 0.25;  // of the error as it is read
constexpr double kSurelyRightMm = 40.0;  // a method this near is read as it should be

/// What programs write, most likely first.
std::vector<PoseCoordinates> usual_coordinates() {
  std::vector<PoseCoordinates> usual;
  const Eigen::Matrix3d same = Eigen::Matrix3d::Identity();
  for (const double unit_mm : {1.0, 1000.0, 10.0}) {
    usual.push_back({PoseCoordinates::Kind::uvd, same, unit_mm});
    for (const char* const axes : {"x,y,z", "x,-y,z", "x,-y,-z"})
      usual.push_back({PoseCoordinates::Kind::xyz, axes_from_text(axes), unit_mm});
  }
  return usual;
}

/// Frames that are compared, spread over the sequence, with their predictions' numbers.
struct Sample {
  Truth truth;
  PoseNumbers numbers;
};

Sample sampled(const Truth& truth, const PoseNumbers& numbers) {
  const std::int64_t frames = numbers.frames();
  const std::int64_t taken = std::min(frames, kFramesLookedAt);
  const auto per_frame = static_cast<std::ptrdiff_t>(3 * numbers.convention.landmarks.size());
  Sample sample{{{truth.sequence.origin, truth.sequence.convention, {}}, {}},
                {numbers.origin, numbers.convention, numbers.coordinates, {}}};
  for (std::int64_t i = 0; i < taken; ++i) {
    const std::int64_t frame = i * frames / taken;
    sample.truth.sequence.poses.push_back(truth.sequence.poses[static_cast<std::size_t>(frame)]);
    sample.truth.projections.push_back(truth.projection(frame));
    const auto begin = numbers.values.begin() + frame * per_frame;
    sample.numbers.values.insert(sample.numbers.values.end(), begin, begin + per_frame);
  }
  return sample;
}

/// Median 3D error of the joints that the truth knows; one that is missing counts as infinitely far.
double median_error(const Sample& sample, const PoseCoordinates& coordinates, PixelOrigin origin) {
  PoseNumbers numbers = sample.numbers;
  numbers.coordinates = coordinates;
  const PoseSequence poses = poses_from(numbers, sample.truth.projections, origin);
  const ConventionMapping mapping = map_convention(poses.convention, sample.truth.sequence.convention);
  std::vector<double> errors;
  for (std::size_t frame = 0; frame < poses.poses.size(); ++frame) {
    const Projection& projection = sample.truth.projections[frame];
    for (std::size_t j = 0; j < mapping.source_index.size(); ++j) {
      const ImagePoint& expected = sample.truth.sequence.poses[frame].joints[j];
      if (mapping.source_index[j] < 0 || expected.is_missing()) continue;
      const ImagePoint& found = poses.poses[frame].joints[static_cast<std::size_t>(mapping.source_index[j])];
      errors.push_back(found.is_missing()
                           ? std::numeric_limits<double>::infinity()
                           : (projection.to_camera(found) - projection.to_camera(expected)).norm());
    }
  }
  return errors.empty() ? kNaN : upper_median(std::span(errors));
}

}  // namespace

std::optional<LikelyCoordinates> likely_coordinates(const Truth& truth, const PoseNumbers& numbers,
                                                    PixelOrigin origin) {
  if (numbers.frames() != static_cast<std::int64_t>(truth.sequence.poses.size())) return std::nullopt;
  const Sample sample = sampled(truth, numbers);
  const double as_read = median_error(sample, numbers.coordinates, origin);
  if (!(as_read > kSurelyRightMm)) return std::nullopt;
  LikelyCoordinates likely{numbers.coordinates, as_read, as_read};
  for (const PoseCoordinates& coordinates : usual_coordinates()) {
    const double error = median_error(sample, coordinates, origin);
    if (error < likely.median_mm) likely = {coordinates, error, as_read};
  }
  if (!(likely.median_mm < kClearlyBetter * as_read)) return std::nullopt;
  return likely;
}

}  // namespace knuckle
