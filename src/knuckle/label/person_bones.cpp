// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/person_bones.h"

#include <cmath>

namespace knuckle {
namespace {

constexpr double kSizeNoise = 0.02;    // of the logarithm of a size that was fitted to a verified hand
constexpr double kLengthNoise = 0.05;  // of the logarithm of a bone's proportion

/// Of a logarithm: `prior` deviations wide around 0, then measured `count` times with `noise`.
struct Posterior {
  double mean;
  double spread;
};
Posterior posterior_of(double sum, double count, double prior, double noise) {
  if (prior == 0.0) return {0.0, 0.0};
  const double precision = 1.0 / (prior * prior) + count / (noise * noise);
  return {sum / (noise * noise) / precision, 1.0 / std::sqrt(precision)};
}

}  // namespace

void PersonBones::learn(HandKey hand, const SkeletonPose& fitted) {
  hands_[hand] = fitted;
}

void PersonBones::forget(HandKey hand) {
  hands_.erase(hand);
}

void PersonBones::tell(SkeletonFitOptions& options) const {
  if (hands_.empty()) return;
  const auto count = static_cast<double>(hands_.size());
  double size = 0.0;
  for (const auto& [hand, fitted] : hands_) size += std::log(fitted.size);
  const Posterior of_size = posterior_of(size, count, options.size_spread, kSizeNoise);
  options.size = std::exp(of_size.mean);
  options.size_spread = of_size.spread;
  double widest = 0.0;
  for (std::size_t i = 0; i < 15; ++i) {
    double length = 0.0;
    for (const auto& [hand, fitted] : hands_) length += std::log(fitted.lengths[i / 3][i % 3]);
    const Posterior of_length = posterior_of(length, count, options.length_spread, kLengthNoise);
    options.lengths[i / 3][i % 3] = std::exp(of_length.mean);
    widest = of_length.spread;
  }
  options.length_spread = widest;
}

}  // namespace knuckle
