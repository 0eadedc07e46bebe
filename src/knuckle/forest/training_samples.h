// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/worker_messages.h"

namespace knuckle {

/// Features are kept as 16-bit whole multiples of `step`: a feature loses at most step / 2, and one beyond
/// +-16383 steps is clipped, so that the difference of any two still fits 16 bits.
struct FeatureQuantizer {
  static constexpr int kLargest = 16383;

  float step = 1.0F / 1024;  ///< with it features up to +-16 keep a resolution of 0.001

  /// The nearest multiple of the step; the lowest one for NaN.
  std::int16_t operator()(float value) const;
};

/// Samples to train a forest on: rows of features (16 bits each) and rows of targets. Rows are set in any
/// order, from many threads at once, each at most once; rows never set do not take part.
class TrainingSamples {
 public:
  /// Room for `count` samples. Memory: count * (2 * features + 4 * targets + 1) bytes. `put` may add `spare`
  /// more without a copy of them all.
  TrainingSamples(std::int64_t count, int features, int targets, FeatureQuantizer quantizer = {},
                  std::int64_t spare = 0);

  /// Throws an Error where an index or a length is wrong, or a value is not finite; the row then stays unset.
  void set(std::int64_t index, std::span<const float> features, std::span<const float> targets);

  /// Bytes of a row in a message to another worker.
  std::size_t message_bytes(std::size_t index) const;
  /// Appends a row to the message, its features packed (packed_row.h); it no longer takes part here.
  void take(std::size_t index, std::vector<std::byte>& message);
  /// Reads a row from a message into `index`, which is not set; makes room where it is capacity().
  void put(std::size_t index, MessageReader& reader);

  std::int64_t capacity() const { return static_cast<std::int64_t>(is_set_.size()); }
  bool is_set(std::int64_t index) const { return is_set_[static_cast<std::size_t>(index)] != 0; }
  std::int64_t set_count() const;
  int feature_count() const { return feature_count_; }
  int target_count() const { return target_count_; }
  const FeatureQuantizer& quantizer() const { return quantizer_; }

  const std::int16_t* features(std::size_t index) const { return features_.data() + index * feature_count_; }
  std::span<const float> targets(std::size_t index) const {
    return std::span(targets_).subspan(index * target_count_, static_cast<std::size_t>(target_count_));
  }

  /// The set rows in an order that depends on their contents only (a 64-bit hash), and the hash of them all.
  /// Training works in this order: it makes the forest independent of the order in which samples were handed
  /// over.
  struct CanonicalOrder {
    std::vector<std::uint32_t> indices;
    std::uint64_t hash = 0;
  };
  CanonicalOrder canonical_order() const;
  /// The hash of a row's contents.
  std::uint64_t hash_of(std::size_t index) const;

 private:
  std::span<const std::int16_t> feature_row(std::size_t index) const {
    return std::span(features_).subspan(index * feature_count_, static_cast<std::size_t>(feature_count_));
  }
  std::span<std::int16_t> feature_row(std::size_t index) {
    return std::span(features_).subspan(index * feature_count_, static_cast<std::size_t>(feature_count_));
  }
  std::span<float> target_row(std::size_t index) {
    return std::span(targets_).subspan(index * target_count_, static_cast<std::size_t>(target_count_));
  }

  int feature_count_;
  int target_count_;
  FeatureQuantizer quantizer_;
  std::vector<std::int16_t> features_;
  std::vector<float> targets_;
  std::vector<std::uint8_t> is_set_;
};

}  // namespace knuckle
