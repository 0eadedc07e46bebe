// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/layers/weight_arrays.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

using enum NetworkArray::Precision;

constexpr double kLastDeviation = 0.01;  // of the last layer's weights

/// Uniform numbers of this deviation.
void fill_uniform(std::span<Half> weights, double deviation, Random random) {
  const double bound = std::sqrt(3.0) * deviation;
  const double step = 2.0 * bound / 4294967296.0;  // a random word's
  for (Half& weight : weights) weight = half_of_float(static_cast<float>(step * random() - bound));
}

}  // namespace

std::int64_t NetworkArray::count() const {
  return std::accumulate(shape.begin(), shape.end(), std::int64_t{1}, std::multiplies<>());
}

void add_norm(std::vector<NetworkArray>& arrays, const std::string& name, int channels) {
  arrays.push_back({name + ".weight", {channels}, half});
  arrays.push_back({name + ".bias", {channels}, half});
  arrays.push_back({name + ".running_mean", {channels}, single});
  arrays.push_back({name + ".running_var", {channels}, single});
}

ArraySizes total_sizes(const std::vector<NetworkArray>& arrays) {
  ArraySizes sizes;
  for (const NetworkArray& array : arrays) {
    (array.precision == half ? sizes.halves : sizes.singles) += array.count();
  }
  return sizes;
}

WeightArrays::WeightArrays(std::vector<NetworkArray> arrays) : arrays_(std::move(arrays)) {
  std::size_t half_count = 0;
  std::size_t single_count = 0;
  for (const NetworkArray& array : arrays_) {
    std::size_t& first = array.precision == half ? half_count : single_count;
    const auto count = static_cast<std::size_t>(array.count());
    places_[array.name] = {first, count};
    first += count;
  }
  halves_.resize(half_count);
  singles_.resize(single_count);
}

std::span<Half> WeightArrays::halves(const std::string& name) {
  const Place& place = places_.at(name);
  return std::span(halves_).subspan(place.first, place.count);
}

std::span<const Half> WeightArrays::halves(const std::string& name) const {
  const Place& place = places_.at(name);
  return std::span(halves_).subspan(place.first, place.count);
}

std::span<float> WeightArrays::singles(const std::string& name) {
  const Place& place = places_.at(name);
  return std::span(singles_).subspan(place.first, place.count);
}

std::span<const float> WeightArrays::singles(const std::string& name) const {
  const Place& place = places_.at(name);
  return std::span(singles_).subspan(place.first, place.count);
}

std::vector<float> WeightArrays::floats(const std::string& name) const {
  std::vector<float> values;
  for (const Half half : halves(name)) values.push_back(float_of_half(half));
  return values;
}

void WeightArrays::fill_randomly(std::uint64_t seed) {
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    const NetworkArray& array = arrays_[i];
    if (array.name.ends_with(".running_var")) {
      std::ranges::fill(singles(array.name), 1.0f);
    } else if (array.name.ends_with(".norm.weight")) {
      std::ranges::fill(halves(array.name), half_of_float(1.0f));
    } else if (array.name.ends_with(".weight")) {
      const bool is_last = i + 2 == arrays_.size();  // its bias follows
      const double inputs = static_cast<double>(array.count()) / array.shape.front();
      fill_uniform(halves(array.name), is_last ? kLastDeviation : std::sqrt(2.0 / inputs), Random(seed, i));
    }
  }
}

}  // namespace knuckle
