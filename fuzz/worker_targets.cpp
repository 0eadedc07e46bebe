// SPDX-License-Identifier: Apache-2.0
// What workers of one training send each other.
#include "fuzz_target.h"

#include <array>
#include <new>
#include <stdexcept>
#include <vector>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/forest_trainer.h"
#include "knuckle/forest/pixel_forest_trainer.h"
#include "knuckle/forest/pixel_samples.h"
#include "knuckle/forest/shared_leaves.h"

namespace knuckle::fuzz {

/// Training images, one after another. Each that is read can be trained on: all its pixels lead somewhere.
void run_worker_samples(Bytes bytes) {
  PixelSamples samples(0);
  MessageReader reader(std::as_bytes(bytes));
  while (!reader.is_at_end()) {
    const std::uint32_t index = samples.put(reader);
    const PixelSamples::DepthImage& image = samples.images()[index];
    for (const LabelledPixel& pixel : image.pixels) {
      const std::int16_t depth = image.depth(pixel.column, pixel.row);
      constexpr OffsetPair kFar{kMostOffset, -kMostOffset, -kMostOffset, kMostOffset};
      (void)offset_feature(image.depth, pixel.column, pixel.row, image.scale.at(depth), kFar);
      if (depth < 1 || depth > kFarDepth) throw std::logic_error("a depth that no image has");
    }
  }
  (void)arranged(samples);
}

namespace {

/// The other worker has nothing more to say: in a training it would be lost.
struct WorkerLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One of two workers. What the other one says is the bytes, whatever it is asked.
class TalkingWorkers final : public WorkerGroup {
 public:
  TalkingWorkers(int rank, Bytes says) : rank_(rank), says_(std::as_bytes(says)) {}

  int rank() const override { return rank_; }
  int size() const override { return 2; }
  std::vector<std::byte> exchange(Messages sent, const std::vector<std::int64_t>& sizes) override {
    const auto other = static_cast<std::size_t>(1 - rank_);
    if (sizes[other] > static_cast<std::int64_t>(says_.size())) throw WorkerLost("lost");
    const auto heard = says_.first(static_cast<std::size_t>(sizes[other]));
    says_ = says_.subspan(heard.size());
    // One's own message is the one for oneself.
    const auto own = std::span(sent.bytes)
                         .subspan(rank_ == 0 ? 0 : static_cast<std::size_t>(sent.sizes[0]),
                                  static_cast<std::size_t>(sent.sizes[1 - other]));
    std::vector<std::byte> received(own.begin(), own.end());
    received.insert(rank_ == 0 ? received.end() : received.begin(), heard.begin(), heard.end());
    return received;
  }
  double seconds_in_exchange() const override { return 0.0; }
  std::int64_t bytes_sent() const override { return 0; }

 private:
  int rank_;
  std::span<const std::byte> says_;
};

constexpr TreeOptions kTinyTrees{.max_depth = 3, .splits_per_node = 4, .min_leaf_samples = 1};

/// A pose forest's training, all that the workers say in it.
void share_pose_forest(WorkerGroup& workers) {
  constexpr int kFeatures = 3;
  TrainingSamples samples(4, kFeatures, 2);
  for (int i = 0; i < 4; ++i) {
    const auto x = static_cast<float>(i + 4 * workers.rank());
    samples.set(i, std::array{x, 2.0F - x, 0.5F * x}, std::array{x, 1.0F + x * x});
  }
  const auto forest = train_regression_forest(
      workers, samples, 4 * workers.rank(),
      {.trees = 1, .tree = kTinyTrees, .scoring_dimensions = 1, .leaf_bits = 32, .memory_gb = 1e-4});
  if (forest) (void)forest->predict(std::array<float, kFeatures>{1.0F, 2.0F, 3.0F});
}

/// The same of a segmentation forest.
void share_segmentation_forest(WorkerGroup& workers) {
  const Camera camera{CameraModel::projective, 6, 5, 20.0, 20.0, 3.0, 2.0, {}};
  Image<float> depth(6, 5, 600.0F);
  depth(3, 2) = 400.0F + static_cast<float>(workers.rank());
  PixelSamples samples(1);
  samples.set(0, depth, camera, std::vector<LabelledPixel>{{3, 2, 1}, {4, 4, 0}, {1, 1, 0}});
  const auto forest = train_pixel_forest(workers, samples, workers.rank(),
                                         {.trees = 1, .tree = kTinyTrees, .offsets = {}, .memory_gb = 4e-3});
  if (forest) (void)forest->above(Image<float>(6, 5, 600.0F), camera, 0.5F);
}

/// What all have to say of the leaves of a tree.
void share_leaves(WorkerGroup& workers) {
  TrainingSamples samples(2, 1, 2);
  for (int i = 0; i < 2; ++i) samples.set(i, std::array{1.0F}, std::array{1.0F, 2.0F});
  const std::vector<std::uint32_t> own{0, 1};
  const std::vector<SharedLeaf> leaves{
      {own, {.first = 0, .total = 4, .before = 0, .holder = NodeShare::kSeveral}},
      {own, {.first = 4, .total = 2, .before = 0, .holder = workers.rank()}},
      {{}, {.first = 6, .total = 2, .before = 0, .holder = 1 - workers.rank()}}};
  (void)shared_leaf_means(workers, samples, leaves);
  (void)shared_class_counts(workers, std::vector<std::uint8_t>{1, 0}, leaves);
}

/// Words and texts that all tell each other.
void share_words(WorkerGroup& workers) {
  (void)chained_hash(workers, std::vector<std::uint64_t>{1, 2});
  (void)summed_shares(workers, std::vector<std::uint32_t>{3, 0, 5});
  require_same(workers, "other words", "a");
}

}  // namespace

/// '0' to '3' are worker 0 of two, '4' to '7' worker 1: training a pose forest or a segmentation forest,
/// summing up leaves, and words. What follows is all that the other worker says.
void run_worker_talk(Bytes bytes) {
  constexpr std::array kTasks{share_pose_forest, share_segmentation_forest, share_leaves, share_words};
  const auto [which, says] = selected(bytes, 2 * kTasks.size());
  TalkingWorkers workers(which < kTasks.size() ? 0 : 1, says);
  try {
    kTasks[which % kTasks.size()](workers);
  } catch (const WorkerLost&) {
  } catch (const std::bad_alloc&) {
    // Who says that it has more samples than any machine has costs a training in which it takes part itself.
  } catch (const std::length_error&) {
  }
}

}  // namespace knuckle::fuzz
