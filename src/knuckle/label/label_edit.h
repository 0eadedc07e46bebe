// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/core/frame.h"
#include "knuckle/label/label_change.h"
#include "knuckle/label/label_fit.h"
#include "knuckle/label/label_request.h"

namespace knuckle {

/// Changes a hand's labels as a person asks, without the hand model: all kinds of request but undo, redo and
/// those of masks.
/// `palm_mm` is the length of the hand's palm, for what lies between skin and joint. Returns why that cannot
/// be, in a sentence for the person; empty where it is done.
std::string edit_labels(const LabelRequest& request, const Frame& frame, const Convention& convention,
                        double palm_mm, std::vector<LandmarkLabel>& labels);

/// The hand's mask after a stroke of the brush, or as what was measured on its fitted surface (`fit`, null
/// where there is none), in place of what it was. Returns why that cannot be, in a sentence for the person;
/// empty where it is done.
std::string edit_mask(const LabelRequest& request, const Frame& frame, const LabelFit* fit,
                      std::shared_ptr<const LabelMask>& mask);

}  // namespace knuckle
