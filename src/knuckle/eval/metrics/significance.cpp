// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/significance.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "knuckle/core/random.h"
#include "knuckle/core/statistics.h"

namespace knuckle {
namespace {

constexpr int kResamples = 2000;
constexpr std::int64_t kMostBlocks = 500;  // more would cost time and tell nothing
constexpr std::size_t kMostInPairs = 6;
constexpr std::uint64_t kSeed = 1;

/// Errors of the first method less those of the second, of the frames in which both have a pose.
std::vector<double> paired_differences(const MethodScore& first, const MethodScore& second) {
  assert(first.frame_mean_3d_mm.size() == second.frame_mean_3d_mm.size());
  std::vector<double> paired;
  for (std::size_t i = 0; i < first.frame_mean_3d_mm.size(); ++i) {
    const double a = first.frame_mean_3d_mm[i];
    const double b = second.frame_mean_3d_mm[i];
    if (std::isfinite(a) && std::isfinite(b)) paired.push_back(a - b);
  }
  return paired;
}

/// Correlation of each value with the next one.
double autocorrelation(const std::vector<double>& values) {
  const double middle = mean(values);
  double with_next = 0.0;
  double with_itself = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    with_itself += (values[i] - middle) * (values[i] - middle);
    if (i > 0) with_next += (values[i] - middle) * (values[i - 1] - middle);
  }
  return with_itself > 0.0 ? with_next / with_itself : 0.0;
}

/// Politis and White 2004, section 3.2, with the spectrum of an autoregressive process of first order.
std::int64_t block_length(const std::vector<double>& values) {
  constexpr double kMostCorrelation = 0.98;
  const auto count = static_cast<std::int64_t>(values.size());
  const double correlation = std::clamp(autocorrelation(values), 0.0, kMostCorrelation);
  const double ratio = 2.0 * correlation / (1.0 - correlation * correlation);
  const double length = std::cbrt(1.5 * ratio * ratio * static_cast<double>(count));
  const std::int64_t least = std::max<std::int64_t>(1, count / kMostBlocks);
  const std::int64_t most = std::max<std::int64_t>(1, count / 4);
  return std::clamp(static_cast<std::int64_t>(std::ceil(length)), std::min(least, most), most);
}

/// Sums of all blocks of `length` values that follow each other; the first follows the last.
std::vector<double> block_sums(const std::vector<double>& values, std::int64_t length) {
  std::vector<double> sums(values.size());
  double sum = std::accumulate(values.begin(), values.begin() + length, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    sums[i] = sum;
    sum += values[(i + static_cast<std::size_t>(length)) % values.size()] - values[i];
  }
  return sums;
}

/// Means of the values as other recordings might have had them, sorted.
std::vector<double> resampled_means(const std::vector<double>& values, std::int64_t length) {
  const std::vector<double> sums = block_sums(values, length);
  const auto count = static_cast<std::int64_t>(values.size());
  const std::int64_t blocks = (count + length - 1) / length;
  Random random(kSeed);
  std::vector<double> means(kResamples);
  for (double& mean : means) {
    double sum = 0.0;
    for (std::int64_t i = 0; i < blocks; ++i) sum += sums[random.below(static_cast<std::uint32_t>(count))];
    mean = sum / static_cast<double>(blocks * length);
  }
  std::ranges::sort(means);
  return means;
}

double two_sided_p(const std::vector<double>& sorted_means) {
  const auto not_above = std::ranges::upper_bound(sorted_means, 0.0) - sorted_means.begin();
  const auto not_below = sorted_means.end() - std::ranges::lower_bound(sorted_means, 0.0);
  const auto fewer = static_cast<double>(std::min(not_above, not_below));
  return std::min(1.0, 2.0 * (fewer + 1.0) / (kResamples + 1.0));
}

std::size_t best_of(const std::vector<MethodScore>& methods) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < methods.size(); ++i) {
    const bool is_better = methods[i].mean_3d_mm < methods[best].mean_3d_mm;
    if (is_better || std::isnan(methods[best].mean_3d_mm)) best = i;
  }
  return best;
}

}  // namespace

MethodDifference difference(const MethodScore& first, const MethodScore& second) {
  const std::vector<double> paired = paired_differences(first, second);
  MethodDifference result;
  result.frames = static_cast<std::int64_t>(paired.size());
  if (paired.size() < 2) return result;
  result.block_frames = block_length(paired);
  const std::vector<double> means = resampled_means(paired, result.block_frames);
  constexpr std::size_t kTail = kResamples / 40;  // 2.5 %
  result.mean_mm = mean(paired);
  result.low_mm = means[kTail];
  result.high_mm = means[kResamples - 1 - kTail];
  result.p_value = two_sided_p(means);
  return result;
}

std::vector<MethodDifference> differences(const std::vector<MethodScore>& methods) {
  std::vector<MethodDifference> all;
  const auto add = [&](std::size_t first, std::size_t second) {
    all.push_back(difference(methods[first], methods[second]));
    all.back().first = first;
    all.back().second = second;
  };
  if (methods.size() > kMostInPairs) {
    const std::size_t best = best_of(methods);
    for (std::size_t i = 0; i < methods.size(); ++i) {
      if (i != best) add(best, i);
    }
    return all;
  }
  for (std::size_t i = 0; i < methods.size(); ++i) {
    for (std::size_t k = i + 1; k < methods.size(); ++k) add(i, k);
  }
  return all;
}

}  // namespace knuckle
