// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "knuckle/core/image.h"

namespace knuckle {

/// What was learned about patches from a training set; belongs to the model trained on it.
struct PatchStatistics {
  int size_px = 96;   ///< width and height of the patches
  Image<float> mean;  ///< mean patch to subtract; empty: nothing is subtracted
  std::vector<float>
      whitening;  ///< ZCA matrix, (size_px^2) x (size_px^2), row-major, symmetric; empty: no whitening
};

/// Throws an Error where the parts differ in size or hold values that are not finite.
void check(const PatchStatistics& statistics);

/// The mean of patches, one after another. Sums in double precision, in the order of the calls.
class PatchMean {
 public:
  explicit PatchMean(int size_px);

  /// Throws an Error where the patch has another size.
  void add(const Image<float>& patch);
  std::int64_t count() const { return count_; }
  /// Throws an Error before the first patch.
  Image<float> mean() const;

 private:
  int size_px_;
  std::int64_t count_ = 0;
  std::vector<double> sums_;
};

}  // namespace knuckle
