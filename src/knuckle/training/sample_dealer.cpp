// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/sample_dealer.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "knuckle/core/error.h"

namespace knuckle {
namespace {

constexpr int kPartBits = 32;
constexpr std::uint64_t kWhole = std::uint64_t{1} << kPartBits;

/// How many of the first `count` places a part takes: it rises by 0 or 1 with each place.
std::int64_t taken_of(std::int64_t count, std::uint64_t part) {
  const auto all = static_cast<std::uint64_t>(count);
  return static_cast<std::int64_t>((all >> kPartBits) * part + (((all & (kWhole - 1)) * part) >> kPartBits));
}

}  // namespace

SampleDealer::SampleDealer(std::span<const double> weights) {
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  const bool is_right = !weights.empty() && std::isfinite(sum) &&
                        std::ranges::all_of(weights, [](double weight) { return weight > 0.0; });
  if (!is_right) fail("training: the weights of its sets have to be positive numbers");
  double rest = sum;
  for (const double weight : weights) {
    shares_.push_back(weight / sum);
    const double part = std::min(1.0, weight / rest);
    parts_of_rest_.push_back(static_cast<std::uint64_t>(std::llround(part * static_cast<double>(kWhole))));
    rest -= weight;
  }
  parts_of_rest_.back() = kWhole;
}

SampleDealer::Dealt SampleDealer::at(std::int64_t place) const {
  for (std::size_t group = 0; group + 1 < parts_of_rest_.size(); ++group) {
    const std::int64_t before = taken_of(place, parts_of_rest_[group]);
    if (taken_of(place + 1, parts_of_rest_[group]) > before) return {group, before};
    place -= before;
  }
  return {parts_of_rest_.size() - 1, place};
}

}  // namespace knuckle
