// SPDX-License-Identifier: Apache-2.0
#include "knuckle/forest/training_samples.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/forest/mixed_hash.h"
#include "knuckle/forest/packed_row.h"

namespace knuckle {

namespace {

void require_finite(std::span<const float> values, std::string_view what, std::int64_t sample) {
  const auto fault = std::ranges::find_if(values, [](float value) { return !std::isfinite(value); });
  if (fault != values.end()) {
    fail("training sample {}: {} {} is {}, expected a finite number", sample, what, fault - values.begin(),
         *fault);
  }
}

}  // namespace

std::int16_t FeatureQuantizer::operator()(float value) const {
  const float steps = std::floor(value / step + 0.5F);
  const float low = steps > -kLargest ? steps : -kLargest;  // also for NaN
  return static_cast<std::int16_t>(low < kLargest ? low : kLargest);
}

TrainingSamples::TrainingSamples(std::int64_t count, int features, int targets, FeatureQuantizer quantizer,
                                 std::int64_t spare)
    : feature_count_(features), target_count_(targets), quantizer_(quantizer) {
  const std::int64_t most_samples = std::numeric_limits<std::uint32_t>::max();
  if (count < 0 || count > most_samples)
    fail("training samples: count is {}, expected [0, {}]", count, most_samples);
  const int most_features = std::numeric_limits<std::uint16_t>::max();
  if (features < 1 || features > most_features) {
    fail("training samples: {} features, expected [1, {}]", features, most_features);
  }
  if (targets < 1) fail("training samples: {} targets, expected at least 1", targets);
  features_.reserve(static_cast<std::size_t>(count + spare) * features);
  targets_.reserve(static_cast<std::size_t>(count + spare) * targets);
  features_.resize(static_cast<std::size_t>(count) * features);
  targets_.resize(static_cast<std::size_t>(count) * targets);
  is_set_.resize(static_cast<std::size_t>(count));
}

void TrainingSamples::set(std::int64_t index, std::span<const float> features,
                          std::span<const float> targets) {
  if (index < 0 || index >= capacity()) fail("training sample {}: there is room for {}", index, capacity());
  if (std::ssize(features) != feature_count_ || std::ssize(targets) != target_count_) {
    fail("training sample {}: {} features and {} targets, expected {} and {}", index, features.size(),
         targets.size(), feature_count_, target_count_);
  }
  require_finite(features, "feature", index);
  require_finite(targets, "target", index);
  const auto row = static_cast<std::size_t>(index);
  std::ranges::transform(features, features_.begin() + static_cast<std::ptrdiff_t>(row * feature_count_),
                         quantizer_);
  std::ranges::copy(targets, targets_.begin() + static_cast<std::ptrdiff_t>(row * target_count_));
  is_set_[row] = 1;
}

std::size_t TrainingSamples::message_bytes(std::size_t index) const {
  return packed_bytes(feature_row(index)) + target_count_ * sizeof(float);
}

void TrainingSamples::take(std::size_t index, std::vector<std::byte>& message) {
  append_packed(message, feature_row(index));
  append_values(message, std::span<const float>(target_row(index)));
  is_set_[index] = 0;
}

void TrainingSamples::put(std::size_t index, MessageReader& reader) {
  if (index == is_set_.size()) {
    is_set_.push_back(0);
    features_.resize(features_.size() + static_cast<std::size_t>(feature_count_));
    targets_.resize(targets_.size() + static_cast<std::size_t>(target_count_));
  }
  read_packed(reader, feature_row(index));
  reader.read(target_row(index));
  is_set_[index] = 1;
}

std::int64_t TrainingSamples::set_count() const {
  return std::accumulate(is_set_.begin(), is_set_.end(), std::int64_t{0});
}

std::uint64_t TrainingSamples::hash_of(std::size_t index) const {
  std::uint64_t hash = 0;
  const std::int16_t* row = features(index);
  int feature = 0;
  for (; feature + 4 <= feature_count_; feature += 4) {
    std::uint64_t word = 0;
    for (int i = 0; i < 4; ++i) word = (word << 16U) | static_cast<std::uint16_t>(row[feature + i]);
    hash = mixed_hash(hash, word);
  }
  for (; feature < feature_count_; ++feature)
    hash = mixed_hash(hash, static_cast<std::uint16_t>(row[feature]));
  for (const float target : targets(index)) hash = mixed_hash(hash, std::bit_cast<std::uint32_t>(target));
  return hash;
}

TrainingSamples::CanonicalOrder TrainingSamples::canonical_order() const {
  std::vector<std::uint64_t> hashes(is_set_.size());
  parallel_for(capacity(), [&](std::int64_t i) {
    const auto row = static_cast<std::size_t>(i);
    if (is_set_[row] != 0) hashes[row] = hash_of(row);
  });
  CanonicalOrder order;
  order.indices.reserve(static_cast<std::size_t>(set_count()));
  for (std::uint32_t i = 0; i < is_set_.size(); ++i) {
    if (is_set_[i] != 0) order.indices.push_back(i);
  }
  std::ranges::sort(order.indices, {}, [&](std::uint32_t i) { return std::pair(hashes[i], i); });
  for (const std::uint32_t i : order.indices) order.hash = mixed_hash(order.hash, hashes[i]);
  return order;
}

}  // namespace knuckle
