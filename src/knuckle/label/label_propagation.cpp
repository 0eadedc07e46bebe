// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_propagation.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

/// What an anchor says counts a third after so many frames.
constexpr double kFadingFrames = 6.0;
/// What speaks for the estimates as they are, against anchors whose weight is 1 beside the frame: far from
/// all of them, nothing is mended.
constexpr double kUnmendedWeight = 0.05;
constexpr double kRadPerFrame = 0.15;  // how fast angles change

const LabelAnchor& nearest(const std::vector<LabelAnchor>& anchors) {
  return *std::ranges::min_element(anchors, {}, &LabelAnchor::away);
}

/// The nearest anchor on each side.
std::vector<const LabelAnchor*> neighbours(const std::vector<LabelAnchor>& anchors) {
  std::vector<const LabelAnchor*> found;
  for (const bool is_before : {true, false}) {
    const LabelAnchor* best = nullptr;
    for (const LabelAnchor& anchor : anchors) {
      if (anchor.is_before == is_before && (best == nullptr || anchor.away < best->away)) best = &anchor;
    }
    if (best != nullptr) found.push_back(best);
  }
  return found;
}

}  // namespace

std::vector<ImagePoint> estimates_beside(const Projection& projection, std::vector<ImagePoint> estimates,
                                         const std::vector<LabelAnchor>& anchors) {
  if (std::ranges::all_of(estimates, &ImagePoint::is_missing)) {
    std::ranges::transform(*nearest(anchors).labels, estimates.begin(), &LandmarkLabel::at);
    return estimates;
  }
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (estimates[i].is_missing()) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double weights = kUnmendedWeight;
    for (const LabelAnchor& anchor : anchors) {
      const ImagePoint& from = anchor.estimates[i];
      const ImagePoint& to = (*anchor.labels)[i].at;
      if (from.is_missing() || to.is_missing()) continue;
      const double weight = std::exp(-anchor.away / kFadingFrames);
      sum += weight * (projection.to_camera(to) - projection.to_camera(from));
      weights += weight;
    }
    const ImagePoint moved = projection.to_image(projection.to_camera(estimates[i]) + sum / weights);
    if (!moved.is_missing() && moved.depth_mm > 0.0) estimates[i] = moved;
  }
  return estimates;
}

LabelFitContext context_beside(LabelFitContext context, const std::vector<LabelAnchor>& anchors) {
  const std::vector<const LabelAnchor*> beside = neighbours(anchors);
  double shares = 0.0;
  for (const LabelAnchor* anchor : beside) shares += 1.0 / anchor->away;
  HandAngles expected;
  for (const LabelAnchor* anchor : beside) {
    for (std::size_t i = 0; i < kHandAngleCount; ++i)
      expected.radians[i] += anchor->fit->pose.angles.radians[i] / anchor->away / shares;
  }
  const LabelAnchor& near = nearest(anchors);
  context.start = near.fit->pose;
  context.expected = expected;
  context.expected_rad = kRadPerFrame * std::sqrt(near.away / static_cast<double>(beside.size()));
  return context;
}

}  // namespace knuckle
