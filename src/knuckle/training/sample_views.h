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

/// Samples that are dealt together, numbered one after another.
struct SampleGroup {
  std::int64_t size = 0;
  double weight = 1.0;  ///< its part of what is trained on, against the others' weights
  /// Sizes of the runs that lie together on a disk, in the order of the samples' numbers; empty: in memory.
  std::vector<std::int64_t> runs = {};
  std::int64_t window = 0;  ///< about so many samples of runs are shuffled together
};

/// Samples as a training sees them: each time in another way.
class SampleViews {
 public:
  virtual ~SampleViews() = default;
  /// Number of samples.
  virtual std::int64_t size() const = 0;
  /// The groups that they come in, in the order of their numbers; one of all where nothing else is said.
  virtual std::vector<SampleGroup> groups() const { return {{size(), 1.0}}; }
  /// Shape of what the network sees of one sample: channels, rows, columns.
  virtual std::vector<std::int64_t> input_shape() const = 0;
  /// Shape of the truth of one sample.
  virtual std::vector<std::int64_t> target_shape() const = 0;
  /// Writes one view of sample `index`, a function of `random` alone. Safe to call from many threads.
  virtual void view(std::int64_t index, Random& random, std::span<float> input,
                    std::span<float> target) const = 0;
  /// The samples of these numbers in memory: views that know them by the same numbers, and no others.
  /// nullptr: all are in memory. Safe to call from many threads. Throws where samples cannot be read.
  virtual std::shared_ptr<const SampleViews> fetched(std::span<const std::int64_t> /*indices*/) const {
    return nullptr;
  }
  /// How many samples are to be fetched together.
  virtual std::int64_t most_at_once() const { return 4096; }
};

/// What a network learns of a patch beside joints.
struct PatchQuestions {
  bool side = false;  ///< whether the hand is a right one
  bool hand = false;  ///< whether there is a hand
};

/// One set that poses are learned from. All has to live as long as a training.
struct TrainingCrops {
  const CubeSamples& hands;
  const CubeSamples* things = nullptr;  ///< of the same sizes; none of their joints is known
  double weight = 1.0;                  ///< its part of what is trained on, against the other sets' weights

  std::int64_t size() const { return hands.size() + (things == nullptr ? 0 : things->size()); }
};

/// Makes an input and a target of a crop.
class CropViews {
 public:
  /// Throws an Error where an option is out of range, or a question cannot be learned: sides from views in a
  /// mirror, whether there is a hand from things.
  CropViews(const AugmentationOptions& augmentation, const PatchQuestions& questions, std::int64_t things);

  std::vector<std::int64_t> input_shape(const CubeSamples& sizes) const;
  std::vector<std::int64_t> target_shape(const CubeSamples& sizes) const;
  /// `sizes` are the sample's. In some views hands are seen in a mirror, as left ones, of which no joint is
  /// known: poses are learned of right hands alone. The side of a thing is NaN.
  void view(const CubeSample& sample, const CubeSamples& sizes, bool is_hand, Random& random,
            std::span<float> input, std::span<float> target) const;

 private:
  AugmentationOptions augmentation_;
  PatchQuestions questions_;
};

/// Views of cut-out hands, then of things, set after set; each set is a group. `input`: 1 x size x size;
/// `target`: J x 3 joints in patch coordinates, NaN where not known, then a row for each question, all of
/// whose numbers are the answer.
class CubeSampleViews final : public SampleViews {
 public:
  /// Throws an Error where an option is out of range, a set has no hands or is of another size than the
  /// first, or there is nothing from which a question can be learned.
  CubeSampleViews(std::vector<TrainingCrops> sets, const AugmentationOptions& augmentation,
                  const PatchQuestions& questions = {});

  std::int64_t size() const override;
  std::vector<SampleGroup> groups() const override;
  std::vector<std::int64_t> input_shape() const override;
  std::vector<std::int64_t> target_shape() const override;
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override;

 private:
  std::vector<TrainingCrops> sets_;
  CropViews views_;
};

}  // namespace knuckle
