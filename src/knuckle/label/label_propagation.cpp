// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_propagation.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

/// Frames after which a third of what was mended is left.
constexpr double kFadingFrames = 10.0;
constexpr double kRadPerFrame = 0.15;

const LabelAnchor& nearest(const std::vector<LabelAnchor>& anchors) {
  return *std::ranges::min_element(anchors, {}, &LabelAnchor::away);
}

/// How much each anchor says: all of them 1 together.
std::vector<double> shares_of(const std::vector<LabelAnchor>& anchors) {
  std::vector<double> shares;
  double sum = 0.0;
  for (const LabelAnchor& anchor : anchors) sum += shares.emplace_back(1.0 / anchor.away);
  for (double& share : shares) share /= sum;
  return shares;
}

}  // namespace

std::vector<ImagePoint> estimates_beside(const Projection& projection, std::vector<ImagePoint> estimates,
                                         const std::vector<LabelAnchor>& anchors) {
  if (std::ranges::all_of(estimates, &ImagePoint::is_missing)) {
    std::ranges::transform(*nearest(anchors).labels, estimates.begin(), &LandmarkLabel::at);
    return estimates;
  }
  const std::vector<double> shares = shares_of(anchors);
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (estimates[i].is_missing()) continue;
    Eigen::Vector3d mended = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < anchors.size(); ++k) {
      const ImagePoint& from = anchors[k].estimates[i];
      const ImagePoint& to = (*anchors[k].labels)[i].at;
      if (from.is_missing() || to.is_missing()) continue;
      const double share = shares[k] * std::exp(-(anchors[k].away - 1) / kFadingFrames);
      mended += share * (projection.to_camera(to) - projection.to_camera(from));
    }
    const ImagePoint moved = projection.to_image(projection.to_camera(estimates[i]) + mended);
    if (!moved.is_missing() && moved.depth_mm > 0.0) estimates[i] = moved;
  }
  return estimates;
}

LabelFitContext context_beside(LabelFitContext context, const std::vector<LabelAnchor>& anchors) {
  const std::vector<double> shares = shares_of(anchors);
  HandAngles expected;
  for (std::size_t k = 0; k < anchors.size(); ++k) {
    for (std::size_t i = 0; i < kHandAngleCount; ++i)
      expected.radians[i] += shares[k] * anchors[k].fit->pose.angles.radians[i];
  }
  const LabelAnchor& near = nearest(anchors);
  context.start = near.fit->pose;
  context.expected = expected;
  context.expected_rad = kRadPerFrame * std::sqrt(near.away / static_cast<double>(anchors.size()));
  return context;
}

}  // namespace knuckle
