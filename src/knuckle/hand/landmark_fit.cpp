// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/landmark_fit.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Dense>

#include "knuckle/core/error.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr int kMostSteps = 200;
constexpr double kStep = 1e-9;  // a shorter one ends the search [palm lengths], far below 1 um

/// What the offset of a landmark has to be in one frame.
struct WantedOffset {
  Eigen::Vector3d offset;  ///< from the estimate to the label, in the axes of the bone [palm lengths]
  Eigen::Vector2d shares;  ///< of the straight finger's offset and of the bent one's, together 1
};

/// The two offsets of a landmark as rows: of the straight finger, of the bent one [palm lengths].
using Offsets = Eigen::Matrix<double, 2, 3>;

std::optional<WantedOffset> wanted_in(const LabelledPoints& frame, const DefinedLandmark& defined,
                                      std::size_t landmark) {
  const Point3& label = frame.labelled[landmark];
  const Point3 origin = offset_origin(frame.estimated, defined);
  const auto axes = bone_axes(frame.estimated, frame.side, defined.bone);
  const double unit = palm_length(frame.estimated);
  const double bend = finger_bend(frame.estimated, defined.bone);
  if (!label.allFinite() || !origin.allFinite() || !axes || !(unit > 0.0) || std::isnan(bend))
    return std::nullopt;
  return WantedOffset{axes->transpose() * (label - origin) / unit, {1.0 - bend, bend}};
}

double distance_to(const WantedOffset& wanted, const Offsets& offsets) {
  return (wanted.offset.transpose() - wanted.shares.transpose() * offsets).norm();
}

/// One step of Weiszfeld's: the least squares that each distance's inverse weighs.
Offsets reweighted(std::span<const WantedOffset> frames, const Offsets& start, const Offsets& offsets) {
  constexpr double kNear = 1e-9;  // weights are bounded by its inverse
  Eigen::Matrix2d normal = kStartWeight * Eigen::Matrix2d::Identity();
  Offsets right = kStartWeight * start;
  for (const WantedOffset& wanted : frames) {
    const double weight = 1.0 / std::max(distance_to(wanted, offsets), kNear);
    normal += weight * wanted.shares * wanted.shares.transpose();
    right += weight * wanted.shares * wanted.offset.transpose();
  }
  return normal.ldlt().solve(right);
}

Offsets fitted_offsets(std::span<const WantedOffset> frames, const Offsets& start) {
  Offsets offsets = start;
  for (int step = 0; step < kMostSteps; ++step) {
    const Offsets next = reweighted(frames, start, offsets);
    const double moved = (next - offsets).norm();
    offsets = next;
    if (moved < kStep) break;
  }
  return offsets;
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

/// One landmark in the frames that know it.
struct LandmarkFrames {
  std::vector<WantedOffset> wanted;
  std::vector<double> units;       ///< palm lengths [mm]
  std::vector<double> before_mm;   ///< from the landmark's bone itself to the label
  std::vector<std::size_t> parts;  ///< of the cross-validation
};

LandmarkFrames known_frames(std::span<const LabelledPoints> frames, const DefinedLandmark& defined,
                            std::size_t landmark) {
  LandmarkFrames known;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto wanted = wanted_in(frames[i], defined, landmark);
    if (!wanted) continue;
    known.wanted.push_back(*wanted);
    known.units.push_back(palm_length(frames[i].estimated));
    const Point3& bone = frames[i].estimated[static_cast<std::size_t>(defined.bone)];
    known.before_mm.push_back((frames[i].labelled[landmark] - bone).norm());
    known.parts.push_back(i * kFitParts / frames.size());
  }
  return known;
}

/// Each part of the frames with offsets that were fitted to the others.
RunningMean validated(const LandmarkFrames& known, const Offsets& start) {
  RunningMean mean;
  for (std::size_t part = 0; part < kFitParts; ++part) {
    std::vector<WantedOffset> others;
    for (std::size_t i = 0; i < known.wanted.size(); ++i) {
      if (known.parts[i] != part) others.push_back(known.wanted[i]);
    }
    if (std::ssize(others) < kFewestFittedFrames / 2) continue;
    const Offsets offsets = fitted_offsets(others, start);
    for (std::size_t i = 0; i < known.wanted.size(); ++i) {
      if (known.parts[i] == part) mean.add({known.units[i] * distance_to(known.wanted[i], offsets), 1});
    }
  }
  return mean;
}

FitSums fit_landmark(std::span<const LabelledPoints> frames, DefinedLandmark& defined, std::size_t landmark) {
  const LandmarkFrames known = known_frames(frames, defined, landmark);
  FitSums sums;
  for (const double distance : known.before_mm) sums.before.add({distance, 1});
  if (std::ssize(known.wanted) < kFewestFittedFrames) return sums;
  Offsets start;
  start << defined.offset.transpose(), defined.bent.value_or(defined.offset).transpose();
  const Offsets offsets = fitted_offsets(known.wanted, start);
  for (std::size_t i = 0; i < known.wanted.size(); ++i)
    sums.after.add({known.units[i] * distance_to(known.wanted[i], offsets), 1});
  sums.validated = validated(known, start);
  defined.offset = offsets.row(0);
  defined.bent = offsets.row(1);
  return sums;
}

}  // namespace

LandmarkFit fit_landmarks(const LandmarkDefinition& start, std::span<const LabelledPoints> frames) {
  const Convention& convention = start.convention;
  for (const LabelledPoints& frame : frames) {
    if (std::ssize(frame.labelled) != convention.size()) {
      fail("a frame has {} labels, {} has {} landmarks", frame.labelled.size(), convention.name,
           convention.size());
    }
  }
  LandmarkFit fit{start, {}, {}};
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
