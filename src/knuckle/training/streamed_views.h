// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "knuckle/prepare/sample_stream.h"
#include "knuckle/training/sample_views.h"

namespace knuckle {

/// One set that poses are learned from, which is not in memory.
struct StreamedCrops {
  std::shared_ptr<const SampleStream> hands;
  std::shared_ptr<const SampleStream> things;  ///< of the same sizes; may be nullptr
  double weight = 1.0;  ///< its part of what is trained on, against the other sets' weights

  std::int64_t size() const { return hands->size() + (things == nullptr ? 0 : things->size()); }
};

/// How sets that are not in memory are read.
struct StreamingOptions {
  std::int64_t window = 65536;        ///< samples of a set that are shuffled together, at least 1
  std::int64_t most_at_once = 16384;  ///< samples read together; twice as many are in memory
};

/// Views as CubeSampleViews gives them, of samples that are fetched when they are needed. Numbers are as
/// there. Safe to be used by many threads at once.
class StreamedViews final : public SampleViews {
 public:
  /// Throws as CubeSampleViews does.
  StreamedViews(std::vector<StreamedCrops> sets, const AugmentationOptions& augmentation,
                const PatchQuestions& questions, const StreamingOptions& options);

  std::int64_t size() const override;
  std::vector<SampleGroup> groups() const override;
  std::vector<std::int64_t> input_shape() const override { return views_.input_shape(sizes_); }
  std::vector<std::int64_t> target_shape() const override { return views_.target_shape(sizes_); }
  /// Fetches the one sample.
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override;
  std::shared_ptr<const SampleViews> fetched(std::span<const std::int64_t> indices) const override;
  std::int64_t most_at_once() const override { return options_.most_at_once; }

  /// The most samples that were in memory at any time.
  std::int64_t most_held() const { return count_->most; }

 private:
  /// Samples in memory; outlives the views.
  struct Count {
    std::atomic<std::int64_t> now = 0;
    std::atomic<std::int64_t> most = 0;
    void add(std::int64_t samples);
  };
  class Fetched;
  /// Streams one after another, as samples are numbered.
  struct Part {
    const SampleStream* stream;
    std::int64_t first;
    bool is_hands;
  };

  std::vector<StreamedCrops> sets_;
  CropViews views_;
  StreamingOptions options_;
  CubeSamples sizes_;  ///< without a sample
  std::vector<Part> parts_;
  std::shared_ptr<Count> count_ = std::make_shared<Count>();
};

}  // namespace knuckle
