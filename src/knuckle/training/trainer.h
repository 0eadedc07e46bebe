// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <torch/types.h>

#include "knuckle/pipeline/stopwatch.h"
#include "knuckle/training/batch_loader.h"
#include "knuckle/training/network_training.h"
#include "knuckle/training/optimiser.h"
#include "knuckle/training/sharded_network.h"
#include "knuckle/training/training_task.h"

namespace knuckle {

/// One training, from its beginning or a checkpoint to its end: see `train`.
class Trainer {
 public:
  /// `task` has to live as long as this.
  Trainer(const TrainingTask& task, const NetworkTrainingOptions& options, const NetworkTrainingRun& run);

  /// To the end, or to where it is told to stop. Returns the metrics of all validations.
  std::vector<TrainingMetrics> train();

 private:
  void step(BatchLoader& loader);
  void report_again() const;
  void step_unless_interrupted(BatchLoader& loader);
  /// How much of the training will be done after the next step.
  double progress() const;
  /// Looks how much of the time it may take has gone by, by worker 0's clock; 0 where that is not limited.
  void look_at_time();
  /// Shortens a gradient that is longer than `gradient_clip`.
  double scale_for(double norm) const;
  double decay_of_average() const;

  bool is_first_worker() const { return run_.workers == nullptr || run_.workers->rank() == 0; }
  /// The samples of a batch that this worker makes.
  BatchPlan own_plan() const;
  /// Throws an Error where another worker has other samples or weights, or begins elsewhere.
  void agree() const;

  /// Worker 0 measures the averaged network, keeps it where it is to be kept, and writes a checkpoint.
  void validate(const BatchLoader& loader);
  TrainingMetrics measured(const BatchLoader& loader);
  /// Worker 0's, for all.
  TrainingMetrics shared(const TrainingMetrics& metrics) const;
  bool is_kept(const TrainingMetrics& metrics) const;
  /// How long it will take from here, if it goes on as in this run [s].
  double seconds_left() const;

  /// Begins with another training's weights: for more samples, or the user's own.
  void load_initial();
  void save_checkpoint();
  void load_checkpoint();
  /// What must be the same for a training to go on.
  std::string identity() const;

  const TrainingTask& task_;
  NetworkTrainingOptions options_;
  NetworkTrainingRun run_;
  torch::Device device_;
  std::int64_t step_count_;
  ShardedNetwork network_;
  std::shared_ptr<TrainableModule> averaged_;
  Optimiser optimiser_;
  std::int64_t step_ = 0;
  std::int64_t first_step_ = 0;  // of this run
  std::int64_t end_;             // step at which this run ends
  std::vector<TrainingMetrics> metrics_;
  double loss_sum_ = 0.0;
  std::int64_t loss_count_ = 0;
  double waited_before_ = 0.0;
  Stopwatch since_validation_;
  Stopwatch whole_time_;
  double time_share_ = 0.0;
};

}  // namespace knuckle
