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
#include "knuckle/training/sample_order.h"
#include "knuckle/training/sample_views.h"

namespace knuckle {

/// What is trained on in one step.
struct TrainingBatch {
  std::vector<float> inputs;               ///< N x input_shape
  std::vector<float> targets;              ///< N x target_shape
  std::vector<std::int64_t> input_shape;   ///< of one sample
  std::vector<std::int64_t> target_shape;  ///< of one sample
};

/// The samples of some batches that follow one another, in memory.
struct BatchSamples {
  std::int64_t first = 0;  ///< the batches [first, end)
  std::int64_t end = 0;
  std::vector<std::int64_t> numbers;  ///< of the samples, one batch after another
  std::shared_ptr<const SampleViews> views;
};

/// Batch number `number` of a training: which samples, seen how, is a function of the arguments alone. Groups
/// get their shares (SampleDealer); of each, every sample is seen once before any is seen again, in another
/// order each time (SampleOrder).
class BatchPlan {
 public:
  /// Throws an Error where there is no sample, or a group has none.
  BatchPlan(std::shared_ptr<const SampleViews> samples, int batch_size, std::uint64_t seed);
  /// The plan of samples [begin, end) of each batch: what one of several workers has to make.
  BatchPlan part(int begin, int end) const;
  /// Batch `number`, whose samples are fetched for it alone.
  TrainingBatch batch(std::int64_t number) { return batch(number, fetched(number, number + 1)); }
  /// A batch of those whose samples were fetched.
  TrainingBatch batch(std::int64_t number, const BatchSamples& samples) const;
  /// The samples of batches [first, end), those of this part alone. Throws what fetching them throws.
  BatchSamples fetched(std::int64_t first, std::int64_t end);
  /// How many batches are to be fetched together.
  std::int64_t most_at_once() const;
  int batch_size() const { return batch_size_; }  ///< of whole batches
  /// The number of the sample that is dealt to a place: the i-th of batch b has the place b batch_size + i.
  std::int64_t sample_of(std::int64_t place);

 private:
  std::shared_ptr<const SampleViews> samples_;
  int batch_size_;
  int begin_ = 0;  // of the part of a batch that is made
  int end_;
  std::uint64_t seed_;
  std::vector<std::int64_t> first_of_group_;
  std::vector<SampleOrder> orders_;
  SampleDealer dealer_;
};

/// Makes batches ahead on a thread of its own, so that training need not wait; while it does so another one
/// fetches the samples of the next.
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
  void fetch_and_make(std::int64_t first, std::int64_t end);
  /// Hands a batch over when there is room; false where no more are wanted.
  bool hand_over(TrainingBatch batch);

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
