// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/core/statistics.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/surface_near.h"

namespace knuckle {
namespace {

constexpr int kWristAndPalm = 2;  // landmarks of the 22 before those of the digits
constexpr int kPerDigit = 4;

/// 0 thumb to 4 little; -1: wrist, palm, or none of the 22.
int digit_of(Landmark landmark) {
  const int number = static_cast<int>(landmark);
  return number < kWristAndPalm || number >= kSupersetSize ? -1 : (number - kWristAndPalm) / kPerDigit;
}

Point3 in_mirror(const Point3& point, HandSide side) {
  return side == HandSide::left ? Point3(-point.x(), point.y(), point.z()) : point;
}

std::array<bool, 5> corrected_digits(const Convention& convention, const std::vector<LandmarkLabel>& labels) {
  std::array<bool, 5> digits{};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const int digit = digit_of(convention.landmarks[i]);
    if (digit >= 0 && labels[i].is_pinned()) digits[static_cast<std::size_t>(digit)] = true;
  }
  return digits;
}

/// The deviation of a label that is pinned or estimated; nothing where it says nothing.
std::optional<double> deviation_mm(const LandmarkLabel& label, bool is_beside_pin,
                                   const LabelFitOptions& options) {
  if (label.is_pinned()) return options.pin_mm;
  if (!label.is_visible) return std::nullopt;
  return is_beside_pin ? options.beside_pin_mm : options.estimate_mm;
}

LandmarkTargets targets_of(const Projection& projection, const Convention& convention,
                           const std::vector<LandmarkLabel>& labels, const std::vector<ImagePoint>& estimates,
                           const LabelFitOptions& options, std::optional<std::size_t> left_out) {
  const double noise_mm = SkeletonFitOptions().noise_mm;
  const std::array<bool, 5> corrected = corrected_digits(convention, labels);
  LandmarkTargets targets;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(convention.landmarks[i]);
    if (landmark >= targets.size()) continue;
    const ImagePoint& at = labels[i].is_pinned() || i >= estimates.size() ? labels[i].at : estimates[i];
    const int digit = digit_of(convention.landmarks[i]);
    const bool is_beside_pin = digit >= 0 && corrected[static_cast<std::size_t>(digit)];
    const auto deviation = deviation_mm(labels[i], is_beside_pin, options);
    if (at.is_missing() || !(at.depth_mm > 0.0) || !deviation || left_out == i) continue;
    targets[landmark] = {projection.to_camera(at), std::pow(noise_mm / *deviation, 2.0)};
  }
  return targets;
}

/// As a fit to a right hand sees it.
void put_in_mirror(LandmarkTargets& targets, HandSurface& surface) {
  for (LandmarkTarget& target : targets) target.point = in_mirror(target.point, HandSide::left);
  for (Point3& point : surface.points) point = in_mirror(point, HandSide::left);
  surface.depth_mm = [depth = std::move(surface.depth_mm)](const Point3& point) {
    return depth(in_mirror(point, HandSide::left));
  };
}

/// From a start, and afresh where that ends worse than an estimate usually is.
std::optional<SkeletonFit> best_fit(const LandmarkTargets& targets, const SkeletonFitOptions& options,
                                    const std::optional<SkeletonPose>& start, const HandSurface& surface) {
  constexpr double kPoorFitMm = 10.0;
  auto fit = fit_skeleton(adult_skeleton(), targets, options, start, surface);
  if (!start || (fit && fit->rms_mm <= kPoorFitMm)) return fit;
  auto fresh = fit_skeleton(adult_skeleton(), targets, options, std::nullopt, surface);
  return fresh && (!fit || fresh->energy < fit->energy) ? fresh : fit;
}

}  // namespace

std::optional<LabelFit> fit_labels(const Frame& frame, HandSide side, const Convention& convention,
                                   const std::vector<LandmarkLabel>& labels,
                                   const std::vector<ImagePoint>& estimates, const LabelFitContext& context,
                                   const LabelFitOptions& options) {
  const Projection projection(frame.camera);
  LandmarkTargets targets = targets_of(projection, convention, labels, estimates, options, context.left_out);
  HandSurface surface = surface_near(frame, targets);
  if (side == HandSide::left) put_in_mirror(targets, surface);
  SkeletonFitOptions of_skeleton;
  of_skeleton.expected = context.expected;
  of_skeleton.expected_rad = context.expected_rad;
  if (context.bones != nullptr) context.bones->tell(of_skeleton);
  const auto fit = best_fit(targets, of_skeleton, context.start, surface);
  if (!fit) return std::nullopt;
  LabelFit answer{.pose = fit->pose, .points = {}, .rms_mm = fit->rms_mm, .gap_mm = fit->gap_mm};
  const auto points = landmarks(adult_skeleton(), fit->pose);
  for (const Landmark landmark : convention.landmarks) {
    const auto number = static_cast<std::size_t>(landmark);
    const bool is_seen = number < points.size() && points[number].z() > 0.0;
    answer.points.push_back(is_seen ? projection.to_image(in_mirror(points[number], side)) : ImagePoint{});
  }
  return answer;
}

std::vector<LandmarkLabel> with_fit(std::vector<LandmarkLabel> labels, const LabelFit& fit,
                                    LabelState state) {
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i].is_pinned() || fit.points[i].is_missing()) continue;
    labels[i].at = fit.points[i];
    labels[i].state = state;
  }
  return labels;
}

/// In palm lengths: medians over 240 frames of manifests/test_creative.toml, fingers alike.
double depth_below_skin_mm(Landmark landmark, double palm_mm) {
  constexpr double kWrist = 0.38;
  constexpr double kPalm = 0.30;
  constexpr std::array<double, kPerDigit> kThumb{0.35, 0.17, 0.105, 0.035};
  constexpr std::array<double, kPerDigit> kFinger{0.17, 0.085, 0.065, 0.03};
  if (landmark == Landmark::wrist) return kWrist * palm_mm;
  if (landmark == Landmark::palm) return kPalm * palm_mm;
  const int digit = digit_of(landmark);
  if (digit < 0) return 0.0;
  const auto part = static_cast<std::size_t>((static_cast<int>(landmark) - kWristAndPalm) % kPerDigit);
  return palm_mm * (digit == 0 ? kThumb : kFinger)[part];
}

SkinDepths skin_depths(const std::vector<ImagePoint>& landmarks) {
  constexpr double kMarginMm = 45.0;  // fingers that were estimated wrong may be that far off
  constexpr int kFewest = 3;
  SkinDepths depths{.near_mm = 1e9, .far_mm = 0.0};
  int known = 0;
  for (const ImagePoint& point : landmarks) {
    if (point.is_missing()) continue;
    depths.near_mm = std::min(depths.near_mm, point.depth_mm - kMarginMm);
    depths.far_mm = std::max(depths.far_mm, point.depth_mm + kMarginMm);
    ++known;
  }
  return known < kFewest ? SkinDepths() : depths;
}

std::optional<double> skin_depth_at(const Frame& frame, double u, double v, const SkinDepths& depths) {
  constexpr int kFarthestPx = 6;
  const int column = static_cast<int>(std::lround(u));
  const int row = static_cast<int>(std::lround(v));
  for (int reach = 1; reach <= kFarthestPx; ++reach) {
    std::vector<double> found;
    for (int y = std::max(0, row - reach); y <= std::min(frame.depth_mm.height() - 1, row + reach); ++y) {
      for (int x = std::max(0, column - reach); x <= std::min(frame.depth_mm.width() - 1, column + reach);
           ++x) {
        const auto depth = static_cast<double>(frame.depth_mm(x, y));
        if (is_measured(frame.depth_mm(x, y)) && depth >= depths.near_mm && depth <= depths.far_mm)
          found.push_back(depth);
      }
    }
    if (!found.empty()) return median(std::move(found));
  }
  return std::nullopt;
}

ImagePoint placed_on_pixel(const Frame& frame, double u, double v, Landmark landmark, double palm_mm,
                           double depth_mm, const SkinDepths& depths) {
  const auto skin = skin_depth_at(frame, u, v, depths);
  if (skin) return {u, v, *skin + depth_below_skin_mm(landmark, palm_mm)};
  return depth_mm > 0.0 ? ImagePoint{u, v, depth_mm} : ImagePoint{};
}

double settled_depth_mm(double measured_mm, double fitted_mm) {
  constexpr double kFarMm = 30.0;
  const double apart = (fitted_mm - measured_mm) / kFarMm;
  const double trust = 2.0 * std::pow(1.0 + apart * apart, -2.0);
  return (trust * measured_mm + fitted_mm) / (trust + 1.0);
}

}  // namespace knuckle
