// SPDX-License-Identifier: Apache-2.0
#include "knuckle/training/detector_training_task.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <torch/utils.h>

#include "knuckle/core/error.h"
#include "knuckle/core/parallel.h"
#include "knuckle/segment/detector/detector_file.h"
#include "knuckle/segment/detector/detector_relief.h"
#include "knuckle/training/detector_network.h"
#include "knuckle/training/detector_training.h"
#include "knuckle/training/fetched_numbers.h"
#include "knuckle/training/network_writer.h"
#include "knuckle/training/torch_threads.h"

namespace knuckle {
namespace {

constexpr std::int64_t kChunk = 32;
constexpr double kFoundMm = 40.0;
/// A detection that is so near a hand that does not count is not wrong.
constexpr double kExcusedMm = 150.0;

std::size_t cells_of(const DetectorOptions& options) {
  return static_cast<std::size_t>(options.width) * options.height;
}

/// The planes of an input that a frame fills.
std::span<float> measured_in(const DetectorOptions& options, std::span<float> input) {
  return input.first(kMeasuredInputs * cells_of(options));
}

/// Fills the planes that follow from those, where the network sees them.
void add_reliefs(const DetectorOptions& options, std::span<float> input) {
  if (!options.relief) return;
  const std::size_t cells = cells_of(options);
  write_reliefs(options, input.first(cells), input.subspan(kMeasuredInputs * cells));
}

struct Truth {
  Point3 centre;
  float side;
  bool counts;
};

std::vector<Truth> truths_in(std::span<const float> hands, const DetectorView& view) {
  std::vector<Truth> truths;
  for (std::size_t first = 0; first < hands.size(); first += kHandNumbers) {
    const float* const hand = hands.data() + first;
    if (std::isnan(hand[kHandCounts])) continue;
    const double inverse_depth = std::exp(static_cast<double>(hand[kHandInverseDepth]));
    truths.push_back({view.to_camera({hand[kHandU], hand[kHandV], inverse_depth}), hand[kHandSide],
                      hand[kHandCounts] > 0.5f});
  }
  return truths;
}

/// The truth nearest to a point among those that count or not, whose distance is below `most_mm`; or null.
const Truth* nearest_of(const std::vector<Truth>& truths, const Point3& point, bool that_count,
                        double most_mm) {
  const Truth* nearest = nullptr;
  for (const Truth& truth : truths) {
    const double distance = (truth.centre - point).norm();
    if (truth.counts != that_count || distance > most_mm) continue;
    if (nearest == nullptr || distance < (nearest->centre - point).norm()) nearest = &truth;
  }
  return nearest;
}

}  // namespace

DetectorSampleViews::DetectorSampleViews(const DetectorSamples& samples,
                                         const DetectorAugmentation& augmentation)
    : samples_(samples), augmentation_(augmentation) {
  check_options(augmentation, "augmentation");
}

std::vector<std::int64_t> DetectorSampleViews::input_shape() const {
  const DetectorOptions& options = samples_.options();
  return {options.inputs(), options.height, options.width};
}

std::vector<std::int64_t> DetectorSampleViews::target_shape() const {
  return {static_cast<std::int64_t>(kMostLabelledHands), static_cast<std::int64_t>(kHandNumbers)};
}

void DetectorSampleViews::view(std::int64_t index, Random& random, std::span<float> input,
                               std::span<float> target) const {
  const DetectorOptions& options = samples_.options();
  const DetectorSample sample = samples_.sample(index);
  const PictureView seen = random_view(augmentation_, random);
  const std::span<float> measured = measured_in(options, input);
  view_cells(sample, options, seen, measured);
  view_hands(sample, options, seen, target);
  spoil_cells(augmentation_, options, random, measured);
  excuse_unseen_hands(options, measured, target);
  add_reliefs(options, input);
}

/// Some frames in memory.
class StreamedDetectorViews::Fetched final : public SampleViews {
 public:
  Fetched(const StreamedDetectorViews& all, std::span<const std::int64_t> indices)
      : numbers_(indices),
        samples_(all.frames_.options(), numbers_.size()),
        views_(samples_, all.augmentation_) {
    parallel_for(size(), [&](std::int64_t i) { all.frames_.put(numbers_[i], samples_, i); });
  }
  std::int64_t size() const override { return numbers_.size(); }
  std::vector<std::int64_t> input_shape() const override { return views_.input_shape(); }
  std::vector<std::int64_t> target_shape() const override { return views_.target_shape(); }
  void view(std::int64_t index, Random& random, std::span<float> input,
            std::span<float> target) const override {
    views_.view(numbers_.place_of(index), random, input, target);
  }

 private:
  FetchedNumbers numbers_;
  DetectorSamples samples_;
  DetectorSampleViews views_;
};

StreamedDetectorViews::StreamedDetectorViews(const DetectorFrames& frames,
                                             const DetectorAugmentation& augmentation,
                                             std::int64_t most_at_once)
    : frames_(frames),
      augmentation_(augmentation),
      most_at_once_(most_at_once),
      none_(frames.options(), 0),
      shapes_(none_, augmentation) {}

void StreamedDetectorViews::view(std::int64_t index, Random& random, std::span<float> input,
                                 std::span<float> target) const {
  fetched(std::span(&index, 1))->view(index, random, input, target);
}

std::shared_ptr<const SampleViews> StreamedDetectorViews::fetched(
    std::span<const std::int64_t> indices) const {
  return std::make_shared<const Fetched>(*this, indices);
}

void DetectionCounts::add(const DetectionCounts& other) {
  frames += other.frames;
  hands += other.hands;
  found += other.found;
  invented += other.invented;
  sides_known += other.sides_known;
  sides_right += other.sides_right;
  distance_mm += other.distance_mm;
}

std::vector<double> DetectionCounts::scores() const {
  const auto share = [](auto part, std::int64_t whole) {
    return whole == 0 ? kNaN : static_cast<double>(part) / static_cast<double>(whole);
  };
  const std::int64_t mistakes = hands - found + invented + sides_known - sides_right;
  std::vector<double> scores(kDetectorScores);
  scores[kRecall] = share(found, hands);
  scores[kFalsePositives] = share(invented, frames);
  scores[kSideAccuracy] = share(sides_right, sides_known);
  scores[kCentreMm] = share(distance_mm, found);
  scores[kMistakes] = share(mistakes, std::max<std::int64_t>(1, hands));
  return scores;
}

DetectionCounts counts_of(const std::vector<DetectedHand>& detected, std::span<const float> hands,
                          const DetectorView& view) {
  std::vector<Truth> truths = truths_in(hands, view);
  DetectionCounts counts{.frames = 1};
  counts.hands = std::ranges::count_if(truths, &Truth::counts);
  for (const DetectedHand& hand : detected) {
    const Truth* const truth = nearest_of(truths, hand.centre, true, kFoundMm);
    if (truth == nullptr) {
      counts.invented += nearest_of(truths, hand.centre, false, kExcusedMm) == nullptr ? 1 : 0;
      continue;
    }
    ++counts.found;
    counts.distance_mm += (truth->centre - hand.centre).norm();
    if (!std::isnan(truth->side)) {
      ++counts.sides_known;
      const bool is_right = truth->side > 0.5f;
      counts.sides_right += is_right == (hand.side == HandSide::right) ? 1 : 0;
    }
    truths.erase(truths.begin() + (truth - truths.data()));  // found once
  }
  return counts;
}

Camera camera_of_picture(const DetectorOptions& options) {
  Camera camera;
  camera.width = options.width;
  camera.height = options.height;
  camera.fx = camera.fy = options.focal_cells;
  camera.cx = 0.5 * (options.width - 1);
  camera.cy = 0.5 * (options.height - 1);
  return camera;
}

DetectorMaps maps_of_sample(const torch::Tensor& output, std::int64_t index) {
  const torch::Tensor values =
      output[index].detach().to(torch::kCPU, torch::kFloat).permute({1, 2, 0}).contiguous();
  const float* const first = values.data_ptr<float>();
  return {static_cast<int>(values.size(1)), static_cast<int>(values.size(0)),
          std::vector<float>(first, first + values.numel())};
}

DetectorTrainingTask::DetectorTrainingTask(const DetectorOptions& network,
                                           const DetectorAugmentation& augmentation,
                                           std::shared_ptr<const SampleViews> training,
                                           const DetectorSamples& validation)
    : options_(network), augmentation_(augmentation), views_(std::move(training)), validation_(validation) {}

std::shared_ptr<TrainableModule> DetectorTrainingTask::make_module(std::uint64_t seed) const {
  return make_detector_network(options_, seed);
}

std::vector<double> DetectorTrainingTask::validate(TrainableModule& network,
                                                   const torch::Device& device) const {
  const DetectorView view(options_, camera_of_picture(options_));
  const std::int64_t chunks = (validation_.size() + kChunk - 1) / kChunk;
  std::vector<DetectionCounts> counts(static_cast<std::size_t>(chunks));
  parallel_for(chunks, [&](std::int64_t chunk) {
    use_calling_thread_alone();
    const c10::InferenceMode inference;
    const std::int64_t first = chunk * kChunk;
    const std::int64_t size = std::min(kChunk, validation_.size() - first);
    torch::Tensor inputs = torch::empty({size, options_.inputs(), options_.height, options_.width});
    const auto numbers = static_cast<std::size_t>(inputs.numel() / size);
    const auto input_of = [&](std::int64_t i) {
      return std::span(inputs.data_ptr<float>() + static_cast<std::size_t>(i) * numbers, numbers);
    };
    for (std::int64_t i = 0; i < size; ++i) {
      view_cells(validation_.sample(first + i), options_, {}, measured_in(options_, input_of(i)));
      add_reliefs(options_, input_of(i));
    }
    const torch::Tensor output = network.forward(inputs.to(device));
    for (std::int64_t i = 0; i < size; ++i) {
      LabelledHands hands;
      view_hands(validation_.sample(first + i), options_, {}, hands);
      excuse_unseen_hands(options_, measured_in(options_, input_of(i)), hands);
      const auto detected = hands_in(maps_of_sample(output, i), view, {});
      counts[static_cast<std::size_t>(chunk)].add(counts_of(detected, hands, view));
    }
  });
  DetectionCounts sum;
  for (const DetectionCounts& part : counts) sum.add(part);
  return sum.scores();
}

void DetectorTrainingTask::save(const std::filesystem::path& path, const TrainableModule& network) const {
  DetectorWeights weights(options_);
  copy_weights(network, weights);
  save_detector_weights(path, weights);
}

void DetectorTrainingTask::load(const std::filesystem::path& path, TrainableModule& network) const {
  const DetectorWeights weights = load_detector_weights(path);
  DetectorOptions known = weights.options();
  known.side_weight = options_.side_weight;  // of its training alone
  if (detector_options_as_toml(known) != detector_options_as_toml(options_)) {
    fail("{}: training cannot begin with it: its [network] differs from the configuration's", path.string());
  }
  set_weights(network, weights);
}

std::string DetectorTrainingTask::identity(const std::string& training) const {
  return detector_options_as_toml(options_) + "[training]\n" + training + "[augmentation]\n" +
         options_as_toml(augmentation_);
}

}  // namespace knuckle
