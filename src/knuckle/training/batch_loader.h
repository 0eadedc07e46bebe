// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "knuckle/prepare/cube_samples.h"
#include "knuckle/prepare/cube_view.h"

namespace knuckle {

/// Patches and joints that are trained on in one step.
struct TrainingBatch {
  std::vector<float> patches;  ///< N x size x size
  std::vector<float> joints;   ///< N x J x 3, in patch coordinates; NaN where not known
};

/// Batch number `number` of a training: which samples, seen how, is a function of the arguments alone. Every
/// sample is seen once before any is seen again, in another order each time.
class BatchPlan {
 public:
  BatchPlan(const CubeSamples& samples, const AugmentationOptions& augmentation, int batch_size,
            std::uint64_t seed);
  TrainingBatch batch(std::int64_t number);
  int batch_size() const { return batch_size_; }

 private:
  std::int64_t sample_of(std::int64_t place);

  const CubeSamples& samples_;
  AugmentationOptions augmentation_;
  int batch_size_;
  std::uint64_t seed_;
  std::int64_t epoch_ = -1;
  std::vector<std::int64_t> order_;
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
