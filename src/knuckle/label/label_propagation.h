// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/camera/projection.h"
#include "knuckle/label/label_fit.h"

namespace knuckle {

/// A verified hand that another frame's hand of the same sequence follows.
struct LabelAnchor {
  int away = 1;                                        ///< frames between both, at least 1
  bool is_before = true;                               ///< the anchor comes first
  const LabelFit* fit = nullptr;                       ///< to its labels
  const std::vector<LandmarkLabel>* labels = nullptr;  ///< one per landmark of the convention
  std::vector<ImagePoint> estimates;  ///< where the estimator had seen them; missing where it had not
};

/// The estimates of a frame, mended by what persons mended at the anchors around it (at least one): an
/// estimator errs alike in frames that are near each other. It is a mean of what was mended there, in which
/// near anchors count more, so that the tremble of many clicks averages out; far from all anchors nothing is
/// mended. Where nothing was estimated, the nearest anchor's labels.
std::vector<ImagePoint> estimates_beside(const Projection& projection, std::vector<ImagePoint> estimates,
                                         const std::vector<LabelAnchor>& anchors);

/// What the nearest anchor on each side says of the pose between them, for a fit: it begins at the nearer
/// one's, and its angles are expected on the way from one to the other, the less surely the farther they are.
LabelFitContext context_beside(LabelFitContext context, const std::vector<LabelAnchor>& anchors);

}  // namespace knuckle
