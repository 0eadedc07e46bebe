// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include "knuckle/prepare/detector_augmentation.h"
#include "knuckle/segment/detector/detection.h"
#include "knuckle/training/training_task.h"

namespace knuckle {

/// Random views of frames with hands. `input`: 2 x height x width; `target`: kMostLabelledHands x
/// kHandNumbers.
class DetectorSampleViews final : public SampleViews {
 public:
  /// `samples` has to live as long as this. Throws an Error where an option is out of range.
  DetectorSampleViews(const DetectorSamples& samples, const DetectorAugmentation& augmentation);

  std::int64_t size() const override { return samples_.size(); }
  std::vector<std::int64_t> input_shape() const override;
  std::vector<std::int64_t> target_shape() const override;
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override;

 private:
  const DetectorSamples& samples_;
  DetectorAugmentation augmentation_;
};

/// The same of frames that are not in memory, read when they are needed. Numbers are those of the frames.
/// Safe to be used by many threads at once.
class StreamedDetectorViews final : public SampleViews {
 public:
  /// `frames` have to live as long as this; of them `most_at_once`, at least 1, are read together.
  StreamedDetectorViews(const DetectorFrames& frames, const DetectorAugmentation& augmentation,
                        std::int64_t most_at_once);

  std::int64_t size() const override { return frames_.size(); }
  std::vector<std::int64_t> input_shape() const override { return shapes_.input_shape(); }
  std::vector<std::int64_t> target_shape() const override { return shapes_.target_shape(); }
  /// Reads the one frame.
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override;
  std::shared_ptr<const SampleViews> fetched(std::span<const std::int64_t> indices) const override;
  std::int64_t most_at_once() const override { return most_at_once_; }

 private:
  class Fetched;

  const DetectorFrames& frames_;
  DetectorAugmentation augmentation_;
  std::int64_t most_at_once_;
  DetectorSamples none_;
  DetectorSampleViews shapes_;  ///< of no sample
};

/// What is counted in a detector's validation.
struct DetectionCounts {
  std::int64_t frames = 0;
  std::int64_t hands = 0;
  std::int64_t found = 0;
  std::int64_t invented = 0;
  std::int64_t sides_known = 0;  ///< of the hands found
  std::int64_t sides_right = 0;
  double distance_mm = 0.0;  ///< sum over the hands found

  void add(const DetectionCounts& other);
  /// DetectorScore.
  std::vector<double> scores() const;
};

/// Counts one frame: detections against labelled hands (kMostLabelledHands x kHandNumbers), both in `view`.
DetectionCounts counts_of(const std::vector<DetectedHand>& detected, std::span<const float> hands,
                          const DetectorView& view);

/// The training of a detector.
class DetectorTrainingTask final : public TrainingTask {
 public:
  /// `validation` has to live as long as this.
  DetectorTrainingTask(const DetectorOptions& network, const DetectorAugmentation& augmentation,
                       std::shared_ptr<const SampleViews> training, const DetectorSamples& validation);

  std::shared_ptr<TrainableModule> make_module(std::uint64_t seed) const override;
  std::shared_ptr<const SampleViews> views() const override { return views_; }
  std::vector<double> validate(TrainableModule& network, const torch::Device& device) const override;
  void save(const std::filesystem::path& path, const TrainableModule& network) const override;
  void load(const std::filesystem::path& path, TrainableModule& network) const override;
  std::string identity(const std::string& training) const override;

 private:
  DetectorOptions options_;
  DetectorAugmentation augmentation_;
  std::shared_ptr<const SampleViews> views_;
  const DetectorSamples& validation_;
};

/// The camera whose frames look as the network's small picture does.
Camera camera_of_picture(const DetectorOptions& options);

/// The maps of sample `index` in a network's output, N x kDetectorMaps x height x width.
DetectorMaps maps_of_sample(const torch::Tensor& output, std::int64_t index);

}  // namespace knuckle
