// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "knuckle/core/random.h"
#include "knuckle/prepare/cube_samples.h"
#include "knuckle/prepare/cube_view.h"

namespace knuckle {

/// Samples as a training sees them: each time in another way.
class SampleViews {
 public:
  virtual ~SampleViews() = default;
  /// Number of samples.
  virtual std::int64_t size() const = 0;
  /// Shape of what the network sees of one sample: channels, rows, columns.
  virtual std::vector<std::int64_t> input_shape() const = 0;
  /// Shape of the truth of one sample.
  virtual std::vector<std::int64_t> target_shape() const = 0;
  /// Writes one view of sample `index`, a function of `random` alone. Safe to call from many threads.
  virtual void view(std::int64_t index, Random& random, std::span<float> input,
                    std::span<float> target) const = 0;
};

/// Views of cut-out hands. `input`: 1 x size x size; `target`: J x 3 joints in patch coordinates, NaN where
/// not known. For a network that tells sides there is one row more, whose first number is 1, or 0 in a view
/// in a mirror, of which no joint is known: poses are learned of right hands alone.
class CubeSampleViews final : public SampleViews {
 public:
  /// `samples` has to live as long as this. Throws an Error where an option is out of range.
  CubeSampleViews(const CubeSamples& samples, const AugmentationOptions& augmentation,
                  bool tells_side = false);

  std::int64_t size() const override { return samples_.size(); }
  std::vector<std::int64_t> input_shape() const override;
  std::vector<std::int64_t> target_shape() const override;
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override;

 private:
  const CubeSamples& samples_;
  AugmentationOptions augmentation_;
  bool tells_side_;
};

}  // namespace knuckle
