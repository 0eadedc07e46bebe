// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/core/image.h"

namespace knuckle {

/// What was learned about patches from a training set; belongs to the model trained on it.
struct PatchStatistics {
  int size_px = 96;             ///< width and height of the patches
  Image<float> mean;            ///< mean patch to subtract; empty: nothing is subtracted
  std::vector<float> whitening; ///< ZCA matrix, (size_px^2) x (size_px^2), row-major, symmetric; empty: no whitening
};

}  // namespace knuckle
