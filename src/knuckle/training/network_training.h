// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "knuckle/core/worker_group.h"
#include "knuckle/net/network_options.h"
#include "knuckle/prepare/cube_samples.h"
#include "knuckle/prepare/cube_view.h"
#include "knuckle/training/learning_rate.h"
#include "knuckle/training/sample_views.h"
#include "knuckle/training/streamed_views.h"

namespace knuckle {

/// How a network is trained: the `[training]` table.
struct NetworkTrainingOptions {
  double epochs = 10.0;             ///< Samples seen, as a multiple of all samples of all sets, (0, 1e6]
  int batch_size = 64;              ///< Samples a step, [1, 65536]
  int shards = 4;                   ///< Parts of a batch that are worked on side by side, [1, 256]
  std::string optimiser = "adamw";  ///< adamw | sgd
  /// single | bfloat16: the numbers that layers multiply and keep. Training in 16 bits is faster on
  /// processors that have instructions for them (AMX); weights and loss stay `single`.
  std::string precision = "single";
  double momentum = 0.9;         ///< sgd's, [0, 1)
  double weight_decay = 1e-4;    ///< [0, 1]
  double gradient_clip = 1.0;    ///< Largest norm of the gradient; 0: any, [0, 1e6]
  double average_decay = 0.999;  ///< of the moving average of the weights, which is what is kept, [0, 1)
  LearningRateOptions learning_rate;
  int validate_every = 1000;  ///< Steps from one validation and checkpoint to the next, [1, 1e9]
  int patience = 0;           ///< Validations without a better one before it stops; 0: never, [0, 1e6]
  /// best | last: which of the validated networks becomes the model. The last where what counts is not what
  /// the validation measures.
  std::string keep = "best";
  std::uint64_t seed = 1;  ///< of weights, orders and views

  void visit(OptionVisitor& visitor);
};

/// Numbers of a validation of a network that infers poses: the mean distance of joints [mm].
enum PoseScore : std::size_t {
  kFirstLook,   ///< around the given centres
  kSecondLook,  ///< after a second look, around the mean of the joints found first; the best has the least
};
/// Their names as metrics.csv has them, in their order.
inline constexpr std::array<std::string_view, 2> kPoseScoreNames{"first_mm", "second_mm"};

/// One line of a training's metrics.
struct TrainingMetrics {
  std::int64_t step = 0;
  std::int64_t samples = 0;  ///< seen so far
  double learning_rate = 0.0;
  double training_loss = 0.0;       ///< mean since the line before
  std::vector<double> validation;   ///< PoseScore, or DetectorScore
  double samples_per_second = 0.0;  ///< since the line before, validation not counted
  double waiting_share = 0.0;       ///< of the time, for batches
};

/// Whether so many validations were no better than the best that the training ends.
bool has_run_out_of_patience(const std::vector<TrainingMetrics>& metrics,
                             const NetworkTrainingOptions& options);

/// Metrics as CSV, a line per validation; `names` are those of its numbers.
std::string metrics_csv(const std::vector<TrainingMetrics>& metrics, std::span<const std::string_view> names);

/// Where and how one training runs.
struct NetworkTrainingRun {
  std::filesystem::path model;       ///< the one to keep so far; written at validations
  std::filesystem::path checkpoint;  ///< all that is needed to go on; written at each validation
  enum class Begin { anew, from_checkpoint } begin = Begin::anew;
  /// A model of the same architecture, convention and patch, whose weights a training anew begins with;
  /// empty: random weights.
  std::filesystem::path initial;
  std::string device = "cpu";  ///< cpu | cuda | cuda:N
  /// The learning rate falls, and the training ends, so that all is done in this time [min]; 0: in its own.
  /// What comes out then depends on how fast the machine was.
  double minutes = 0.0;
  std::int64_t stop_after_steps = 0;  ///< ends early, as if interrupted, after so many steps in all; 0: not
  /// Processes that train the same network on shards of their own: not more than there are shards. All have
  /// the same samples and options, and see the same checkpoint; worker 0 validates, writes and reports.
  /// nullptr: this process alone.
  WorkerGroup* workers = nullptr;
  /// Called once before a training anew with the validation of `initial` as it is; may be empty.
  std::function<void(const std::vector<double>& validation)> report_initial;
  /// Called at each validation with all metrics so far, those before a checkpoint included, and how long the
  /// training will still take where it does not end early [s]; once more where a checkpoint is that of a
  /// training that has ended, since it may have been killed before it reported that. May be empty.
  std::function<void(const std::vector<TrainingMetrics>&, double seconds_left)> report;
};

class TrainingTask;

/// Trains what a task says. Throws as `train_network` does.
std::vector<TrainingMetrics> train(const TrainingTask& task, const NetworkTrainingOptions& options,
                                   const NetworkTrainingRun& run);

/// Trains a network on the sets of `training`, each in its share, and keeps what is best on `validation`, or
/// the last.
/// Joints that are not known (NaN) count in neither.
///
/// A batch is cut into shards, each worked on by one thread; their gradients are summed in order, so the
/// weights depend on options and samples alone, not on the number of threads and workers. Batch norms see one
/// shard at a time; their running statistics are averaged. A training that goes on from a checkpoint ends
/// with the same bits as one that was not interrupted (on one and the same machine and device).
///
/// Throws an Error where an option is out of range, there is no sample, the device is not there, the
/// checkpoint is of another network or configuration, or the loss is not finite: files written before stay as
/// they are.
std::vector<TrainingMetrics> train_network(const NetworkOptions& network,
                                           const NetworkTrainingOptions& options,
                                           const AugmentationOptions& augmentation,
                                           const std::vector<TrainingCrops>& training,
                                           const CubeSamples& validation, const NetworkTrainingRun& run);
/// The same of sets that are not in memory, in the order that SampleOrder gives them.
std::vector<TrainingMetrics> train_network(const NetworkOptions& network,
                                           const NetworkTrainingOptions& options,
                                           const AugmentationOptions& augmentation,
                                           const std::vector<StreamedCrops>& training,
                                           const StreamingOptions& streaming, const CubeSamples& validation,
                                           const NetworkTrainingRun& run);

}  // namespace knuckle
