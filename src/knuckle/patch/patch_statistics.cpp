// SPDX-License-Identifier: Apache-2.0
#include "knuckle/patch/patch_statistics.h"

#include <algorithm>
#include <cmath>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

void check_finite(std::span<const float> values, const char* what) {
  if (!std::ranges::all_of(values, [](float value) { return std::isfinite(value); })) {
    fail("patch statistics: {} holds a value that is not finite", what);
  }
}

void check_patch_size(const Image<float>& patch, int size_px, const char* what) {
  if (patch.width() != size_px || patch.height() != size_px) {
    fail("patch statistics: {} is {} x {} pixels, expected {} x {}", what, patch.width(), patch.height(),
         size_px, size_px);
  }
}

}  // namespace

void check(const PatchStatistics& statistics) {
  const int size_px = statistics.size_px;
  if (size_px < 2 || size_px > 1024) fail("patch statistics: size_px is {}, expected [2, 1024]", size_px);
  if (!statistics.mean.empty()) check_patch_size(statistics.mean, size_px, "the mean patch");
  const std::size_t pixels = static_cast<std::size_t>(size_px) * size_px;
  if (!statistics.whitening.empty() && statistics.whitening.size() != pixels * pixels) {
    fail("patch statistics: the whitening matrix has {} values, expected {}", statistics.whitening.size(),
         pixels * pixels);
  }
  check_finite(statistics.mean.pixels(), "the mean patch");
  check_finite(statistics.whitening, "the whitening matrix");
}

PatchMean::PatchMean(int size_px) : size_px_(size_px), sums_(static_cast<std::size_t>(size_px) * size_px) {}

void PatchMean::add(const Image<float>& patch) {
  check_patch_size(patch, size_px_, "a patch");
  for (std::size_t i = 0; i < sums_.size(); ++i) sums_[i] += patch.data()[i];
  ++count_;
}

Image<float> PatchMean::mean() const {
  if (count_ == 0) fail("patch statistics: there is no patch to take the mean of");
  Image<float> mean(size_px_, size_px_);
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    mean.data()[i] = static_cast<float>(sums_[i] / static_cast<double>(count_));
  }
  return mean;
}

}  // namespace knuckle
