// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/training_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "knuckle/core/text.h"
#include "knuckle/eval/pictures/drawing.h"
#include "knuckle/patch/cube_patch.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/training/batch_loader.h"
#include "knuckle/training/configured_samples.h"

namespace knuckle {
namespace {

constexpr std::int64_t kFramesOfEach = 24;
constexpr int kColumns = 8;
constexpr int kTiles = 6 * kColumns;
constexpr int kTilePx = 192;
constexpr int kGapPx = 4;

/// A network's view as a depth image: near is small, nothing is 0.
Image<float> as_depth(std::span<const float> input, int size) {
  constexpr float kMiddle = 2.0f;  // from -1..1 to 1..3
  Image<float> depth(size, size);
  std::ranges::transform(input, depth.data(),
                         [](float d) { return d < kCubeBackground ? kMiddle + d : 0.0f; });
  return depth;
}

HandPose as_pose(std::span<const float> joints, const Convention& convention, int size) {
  const double half = 0.5 * (size - 1);
  HandPose pose = HandPose::missing(convention);
  for (std::size_t j = 0; j < pose.joints.size(); ++j) {
    pose.joints[j] = {half * (joints[3 * j] + 1.0), half * (joints[3 * j + 1] + 1.0), joints[3 * j + 2]};
  }
  return pose;
}

/// Draws samples as a network sees them.
class SheetPainter {
 public:
  SheetPainter(const NetworkTrainingConfig& config, const std::vector<TrainingCrops>& sets)
      : config_(config),
        convention_(config.network.landmarks()),
        size_(config.network.patch.size_px),
        views_(
            std::make_shared<const CubeSampleViews>(sets, config.augmentation,
                                                    PatchQuestions{.side = config.network.dense.tells_side,
                                                                   .hand = config.network.dense.tells_hand})),
        plan_(views_, kTiles, config.training.seed) {}

  Image<Rgb> paint() {
    const View view{{0, 0, size_, size_}, static_cast<double>(kTilePx) / size_};
    const int rows = kTiles / kColumns;
    Image<Rgb> sheet(kGapPx + kColumns * (view.width() + kGapPx), kGapPx + rows * (view.height() + kGapPx),
                     kSheetColour);
    const TrainingBatch batch = plan_.batch(0);
    for (int i = 0; i < kTiles; ++i) {
      paste(tile(batch, i, view), sheet, kGapPx + i % kColumns * (view.width() + kGapPx),
            kGapPx + i / kColumns * (view.height() + kGapPx));
    }
    return sheet;
  }

 private:
  Image<Rgb> tile(const TrainingBatch& batch, int i, const View& view) {
    constexpr int kMargin = 5;
    const std::size_t pixels = batch.inputs.size() / kTiles;
    const std::size_t numbers = batch.targets.size() / kTiles;
    const auto place = static_cast<std::size_t>(i);
    const Image<float> depth = as_depth(std::span(batch.inputs).subspan(place * pixels, pixels), size_);
    Image<Rgb> picture = picture_of(depth, view, depth_range_in(depth, view.crop));
    const std::span<const float> target = std::span(batch.targets).subspan(place * numbers, numbers);
    draw_skeleton(picture, as_pose(target, convention_, size_), view, kTruthColour);
    draw_text(picture, label(i, target), kMargin, picture.height() - kMargin);
    return picture;
  }

  /// The number of its set, from 1 on, and what else is asked about it.
  std::string label(int place, std::span<const float> target) {
    std::int64_t left = plan_.sample_of(place);
    std::size_t set = 0;
    const std::vector<SampleGroup> groups = views_->groups();
    while (left >= groups[set].size) left -= groups[set++].size;
    std::string text = fmt::format("{}", set + 1);
    std::size_t row = 3 * convention_.landmarks.size();
    if (config_.network.dense.tells_side) {
      if (target[row] == 0.0f) text += " left";
      row += 3;
    }
    if (config_.network.dense.tells_hand && target[row] == 0.0f) text += " thing";
    return text;
  }

  const NetworkTrainingConfig& config_;
  Convention convention_;
  int size_;
  std::shared_ptr<const CubeSampleViews> views_;
  BatchPlan plan_;
};

/// Writes what is told of a training.
class CheckText {
 public:
  CheckText(const NetworkTrainingConfig& config, const ConfiguredSamples& samples)
      : config_(config), samples_(samples) {
    for (const TrainingSource& source : config.sources) {
      weights_.push_back(source.weight);
      frames_.push_back(frames_of(source, Holdout::Part::training));
    }
  }

  std::string text() {
    for (std::size_t i = 0; i < config_.sources.size(); ++i) add_set(i);
    add_validation();
    const std::vector<Landmark> unknown = unknown_landmarks(config_, samples_);
    if (!unknown.empty()) add("no set labels {}: nothing of it is learned\n", names_of(unknown));
    add_network();
    return std::move(text_);
  }

 private:
  template <class... Arguments>
  void add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }

  std::int64_t frames_of(const TrainingSource& source, Holdout::Part part) const {
    SampleOptions options = sample_options(config_, source, part);
    options.most = part == Holdout::Part::training ? source.most : config_.samples.most_validation;
    const auto opened = open_source(source.source);
    const auto hands = std::ssize(frames_for_samples(*opened, options, source.source));
    if (part == Holdout::Part::validation || source.most_things == 0) return hands;
    options.most = source.most_things;
    return hands + std::ssize(frames_for_samples(*opened, options, source.source));
  }

  /// Samples that are trained on in all, if every frame is used.
  double samples_in_all() const {
    double sum = 0.0;
    for (const std::int64_t frames : frames_) sum += static_cast<double>(frames);
    return config_.training.epochs * sum;
  }

  void add_set(std::size_t i) {
    const TrainingSource& source = config_.sources[i];
    const double share = SampleDealer(weights_).share(i);
    add("set {}: {}: {} frames, weight {}, {:.1f}% of the samples: each is seen about {:.1f} times\n", i + 1,
        source.source, frames_[i], source.weight, 100.0 * share,
        samples_in_all() * share / static_cast<double>(frames_[i]));
    add_looked_at(samples_.sets[i].hands);
  }

  void add_validation() {
    if (!config_.validation.empty()) {
      add("validation: {}\n", config_.validation);
    } else {
      add("validation: whole sequences that are held out\n");
      for (const TrainingSource& source : config_.sources) {
        if (source.holdout > 0.0)
          add("  {} frames of {}\n", frames_of(source, Holdout::Part::validation), source.source);
      }
    }
    add_looked_at(samples_.validation);
  }

  void add_looked_at(const NetworkSamples& made) {
    const auto& [total, without_hand, off_centre] = made.frames;
    add("  looked at {} of them: {} used, {} without labels or hand, {} found elsewhere\n", total,
        made.frames.used(), without_hand, off_centre);
    const Convention& convention = config_.network.landmarks();
    const std::vector<bool> known = known_joints(made.samples);
    std::vector<Landmark> unknown;
    for (std::size_t j = 0; j < known.size(); ++j) {
      if (!known[j]) unknown.push_back(convention.landmarks[j]);
    }
    add("  landmarks: {} of {} labelled", known.size() - unknown.size(), known.size());
    if (!unknown.empty()) add(", not {}", names_of(unknown));
    add("\n");
  }

  void add_network() {
    const double steps = std::ceil(samples_in_all() / config_.training.batch_size);
    add("network: {}, {}, begins with {}; {} steps of {} samples\n", config_.network.architecture,
        config_.network.landmarks().name,
        config_.initial.empty() ? std::string("random weights") : config_.initial.string(), steps,
        config_.training.batch_size);
  }

  static std::string names_of(const std::vector<Landmark>& landmarks) {
    std::vector<std::string> names;
    for (const Landmark landmark : landmarks) names.emplace_back(name_of(landmark));
    return joined(names);
  }

  const NetworkTrainingConfig& config_;
  const ConfiguredSamples& samples_;
  std::vector<double> weights_;
  std::vector<std::int64_t> frames_;
  std::string text_;
};

}  // namespace

TrainingCheck check_network_training(const NetworkTrainingConfig& config) {
  check_sources(config);
  const ConfiguredSamples samples = configured_samples(config, {}, kFramesOfEach);
  return {CheckText(config, samples).text(), SheetPainter(config, samples.crops()).paint()};
}

}  // namespace knuckle
