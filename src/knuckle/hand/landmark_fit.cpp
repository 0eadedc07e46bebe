// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/landmark_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "knuckle/core/error.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr int kMostSteps = 200;
constexpr double kStepMm = 1e-9;  // a shorter one ends the search; in palm lengths the same is far below 1 um

/// The offset that would move a frame's estimate of a landmark onto its label, in the axes of its bone.
std::optional<Eigen::Vector3d> offset_in(const LabelledPoints& frame, Landmark bone, std::size_t landmark) {
  const Point3& label = frame.labelled[landmark];
  const Point3& origin = frame.estimated[static_cast<std::size_t>(bone)];
  if (!label.allFinite() || !origin.allFinite()) return std::nullopt;
  const auto axes = bone_axes(frame.estimated, frame.side, bone);
  const double unit = palm_length(frame.estimated);
  if (!axes || !(unit > 0.0)) return std::nullopt;
  return axes->transpose() * (label - origin) / unit;
}

/// Offsets of one landmark, fitted to frames for which `takes(number)`.
template <class Takes>
std::optional<Eigen::Vector3d> fitted_offset(std::span<const LabelledPoints> frames, Landmark bone,
                                             std::size_t landmark, int fewest, const Takes& takes) {
  std::vector<Eigen::Vector3d> offsets;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!takes(i)) continue;
    if (const auto offset = offset_in(frames[i], bone, landmark)) offsets.push_back(*offset);
  }
  if (std::ssize(offsets) < fewest) return std::nullopt;
  return geometric_median(offsets);
}

/// Between a frame's label and its estimate, moved by `offset`.
RunningMean distance_in(const LabelledPoints& frame, Landmark bone, std::size_t landmark,
                        const Eigen::Vector3d& offset) {
  const auto wanted = offset_in(frame, bone, landmark);
  if (!wanted) return {};
  return {(*wanted - offset).norm() * palm_length(frame.estimated), 1};
}

/// The sums that the scores of a landmark, or of all, come from.
struct FitSums {
  RunningMean before;
  RunningMean after;
  RunningMean validated;

  void add(const FitSums& other) {
    before.add(other.before);
    after.add(other.after);
    validated.add(other.validated);
  }
  LandmarkFitScore score() const { return {before.count, before.value(), after.value(), validated.value()}; }
};

FitSums fit_landmark(std::span<const LabelledPoints> frames, DefinedLandmark& defined, std::size_t landmark) {
  const std::size_t count = frames.size();
  const auto part_of = [&](std::size_t frame) { return frame * kFitParts / count; };
  const auto all =
      fitted_offset(frames, defined.bone, landmark, kFewestFittedFrames, [](std::size_t) { return true; });
  FitSums sums;
  if (all) defined.offset = *all;
  for (std::size_t part = 0; part < kFitParts; ++part) {
    const auto without = fitted_offset(frames, defined.bone, landmark, kFewestFittedFrames / 2,
                                       [&](std::size_t frame) { return part_of(frame) != part; });
    for (std::size_t i = 0; i < count; ++i) {
      if (part_of(i) != part) continue;
      sums.before.add(distance_in(frames[i], defined.bone, landmark, Eigen::Vector3d::Zero()));
      if (!all) continue;
      sums.after.add(distance_in(frames[i], defined.bone, landmark, *all));
      if (without) sums.validated.add(distance_in(frames[i], defined.bone, landmark, *without));
    }
  }
  return sums;
}

}  // namespace

Eigen::Vector3d geometric_median(std::span<const Eigen::Vector3d> points) {
  constexpr double kNear = 1e-12;  // weights are bounded by its inverse
  Eigen::Vector3d median = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) median += point / static_cast<double>(points.size());
  for (int step = 0; step < kMostSteps; ++step) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = 0.0;
    for (const Eigen::Vector3d& point : points) {
      const double weight = 1.0 / std::max((point - median).norm(), kNear);
      sum += weight * point;
      weights += weight;
    }
    const Eigen::Vector3d next = sum / weights;
    const double moved = (next - median).norm();
    median = next;
    if (moved < kStepMm) break;
  }
  return median;
}

LandmarkFit fit_landmarks(const Convention& convention, std::span<const LabelledPoints> frames) {
  for (const LabelledPoints& frame : frames) {
    if (std::ssize(frame.labelled) != convention.size()) {
      fail("a frame has {} labels, {} has {} landmarks", frame.labelled.size(), convention.name,
           convention.size());
    }
  }
  LandmarkFit fit{LandmarkDefinition::plain(convention), {}, {}};
  FitSums all;
  bool is_fitted = false;
  for (std::size_t i = 0; i < fit.definition.landmarks.size(); ++i) {
    const FitSums sums = fit_landmark(frames, fit.definition.landmarks[i], i);
    fit.landmarks.push_back(sums.score());
    is_fitted = is_fitted || sums.after.count > 0;
    all.add(sums);
  }
  if (!is_fitted) {
    fail("no landmark of {} is known in {} frames or more, both labelled and estimated: too few to fit",
         convention.name, kFewestFittedFrames);
  }
  fit.all = all.score();
  return fit;
}

}  // namespace knuckle
