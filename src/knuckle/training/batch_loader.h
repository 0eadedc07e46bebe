// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "knuckle/training/sample_dealer.h"
#include "knuckle/training/sample_views.h"

namespace knuckle {

/// What is trained on in one step.
struct TrainingBatch {
  std::vector<float> inputs;               ///< N x input_shape
  std::vector<float> targets;              ///< N x target_shape
  std::vector<std::int64_t> input_shape;   ///< of one sample
  std::vector<std::int64_t> target_shape;  ///< of one sample
};

/// Batch number `number` of a training: which samples, seen how, is a function of the arguments alone. Groups
/// get their shares (SampleDealer); of each, every sample is seen once before any is seen again, in another
/// order each time.
class BatchPlan {
 public:
  /// Throws an Error where there is no sample, or a group has none.
  BatchPlan(std::shared_ptr<const SampleViews> samples, int batch_size, std::uint64_t seed);
  /// The plan of samples [begin, end) of each batch: what one of several workers has to make.
  BatchPlan part(int begin, int end) const;
  TrainingBatch batch(std::int64_t number);
  int batch_size() const { return batch_size_; }  ///< of whole batches
  /// The number of the sample that is dealt to a place: the i-th of batch b has the place b batch_size + i.
  std::int64_t sample_of(std::int64_t place);

 private:
  /// A group in the order of its present epoch.
  struct Deck {
    std::int64_t first = 0;  ///< number of its first sample
    std::int64_t size = 0;
    std::int64_t epoch = -1;
    std::vector<std::int64_t> order;
  };

  std::shared_ptr<const SampleViews> samples_;
  int batch_size_;
  int begin_ = 0;  // of the part of a batch that is made
  int end_;
  std::uint64_t seed_;
  std::vector<Deck> decks_;
  SampleDealer dealer_;
};

/// Makes batches ahead on a thread of its own, so that training need not wait.
class BatchLoader {
 public:
  /// Batches [first, end) of a plan.
  BatchLoader(BatchPlan plan, std::int64_t first, std::int64_t end);
  ~BatchLoader();
  BatchLoader(const BatchLoader&) = delete;
  BatchLoader& operator=(const BatchLoader&) = delete;

  /// The next batch. Throws what making it threw, and where none is left.
  TrainingBatch next();
  /// How long `next` has waited in all [s].
  double waited_seconds() const { return waited_seconds_; }

 private:
  void work(std::int64_t first, std::int64_t end);

  BatchPlan plan_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<TrainingBatch> ready_;
  std::exception_ptr fault_;
  std::int64_t left_;  // batches that `next` has not returned
  bool stop_ = false;
  double waited_seconds_ = 0.0;
  std::jthread thread_;
};

}  // namespace knuckle
