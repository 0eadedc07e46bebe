// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/duration_histogram.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

constexpr int kClasses = 25000;
constexpr double kShortestMs = 1e-4;
constexpr double kStep = 1e-3;  // of the logarithm

int class_of(double duration_ms) {
  if (!(duration_ms > kShortestMs)) return 0;
  return static_cast<int>(std::min<double>(std::log(duration_ms / kShortestMs) / kStep, kClasses - 1));
}

double middle_of(int number) {
  return kShortestMs * std::exp(kStep * (number + 0.5));
}

}  // namespace

DurationHistogram::DurationHistogram() : counts_(kClasses) {}

void DurationHistogram::add(double duration_ms) {
  ++counts_[static_cast<std::size_t>(class_of(duration_ms))];
  ++count_;
}

std::optional<double> DurationHistogram::percentile_ms(double percent) const {
  if (count_ == 0) return std::nullopt;
  const auto wanted = static_cast<std::int64_t>(0.01 * percent * static_cast<double>(count_));
  std::int64_t below = 0;
  for (int number = 0;; ++number) {
    below += counts_[static_cast<std::size_t>(number)];
    if (below > wanted) return middle_of(number);
  }
}

}  // namespace knuckle
