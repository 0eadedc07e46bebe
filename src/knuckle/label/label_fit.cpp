// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_fit.h"

#include <array>
#include <cmath>
#include <utility>

#include "knuckle/camera/projection.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/refine/surface_near.h"

namespace knuckle {
namespace {

/// 0 thumb to 4 little; nothing: wrist, palm, or none of the 22.
std::optional<int> digit_of(Landmark landmark) {
  constexpr int kWristAndPalm = 2;  // landmarks of the 22 before those of the digits
  constexpr int kPerDigit = 4;
  const int number = static_cast<int>(landmark);
  if (number < kWristAndPalm || number >= kSupersetSize) return std::nullopt;
  return (number - kWristAndPalm) / kPerDigit;
}

Point3 in_mirror(const Point3& point, HandSide side) {
  return side == HandSide::left ? Point3(-point.x(), point.y(), point.z()) : point;
}

/// What there is to say of a label, by who made it.
enum class Trust : std::uint8_t { pinned, guessed, estimated, beside_pin };

std::array<bool, 5> corrected_digits(const Convention& convention, const std::vector<LandmarkLabel>& labels) {
  std::array<bool, 5> digits{};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto digit = digit_of(convention.landmarks[i]);
    if (digit && labels[i].is_pinned()) digits[static_cast<std::size_t>(*digit)] = true;
  }
  return digits;
}

/// Nothing where the label does not count.
std::optional<Trust> trust_in(const LandmarkLabel& label, bool is_beside_pin) {
  if (label.is_pinned()) return label.is_visible ? Trust::pinned : Trust::guessed;
  if (!label.is_visible) return std::nullopt;
  return is_beside_pin ? Trust::beside_pin : Trust::estimated;
}

LandmarkTarget target_at(const Point3& point, Trust trust, const LabelFitOptions& options) {
  const auto deviation_mm = [&] {
    switch (trust) {
      case Trust::pinned:
        return options.pin_mm;
      case Trust::guessed:
        return options.guess_mm;
      case Trust::estimated:
        return options.estimate_mm;
      case Trust::beside_pin:
        return options.beside_pin_mm;
    }
    return options.estimate_mm;
  };
  const bool is_of_person = trust == Trust::pinned || trust == Trust::guessed;
  return {.point = point,
          .weight = std::pow(SkeletonFitOptions().noise_mm / deviation_mm(), 2.0),
          .depth_weight = is_of_person ? 1.0 : options.estimate_depth_weight};
}

LandmarkTargets targets_of(const Projection& projection, const Convention& convention,
                           const std::vector<LandmarkLabel>& labels, const std::vector<ImagePoint>& estimates,
                           const LabelFitOptions& options, std::optional<std::size_t> left_out) {
  const std::array<bool, 5> corrected = corrected_digits(convention, labels);
  LandmarkTargets targets;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const auto landmark = static_cast<std::size_t>(convention.landmarks[i]);
    if (landmark >= targets.size()) continue;
    const ImagePoint& at = labels[i].is_pinned() || i >= estimates.size() ? labels[i].at : estimates[i];
    const auto digit = digit_of(convention.landmarks[i]);
    const auto trust = trust_in(labels[i], digit && corrected[static_cast<std::size_t>(*digit)]);
    if (at.is_missing() || !(at.depth_mm > 0.0) || !trust || left_out == i) continue;
    targets[landmark] = target_at(projection.to_camera(at), *trust, options);
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

}  // namespace knuckle
