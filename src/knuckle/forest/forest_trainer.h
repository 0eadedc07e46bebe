// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/forest/regression_forest.h"
#include "knuckle/forest/split_options.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle {

/// Training of a regression forest (Riegler et al. 2015, section 5.2: 8 trees of depth 25).
struct RegressionForestOptions {
  int trees = 8;  ///< [1, 1000]
  TreeOptions tree;
  int scoring_dimensions = 15;  ///< principal components of the targets that score splits, [1, 95]
  int leaf_bits = 16;           ///< bits that a leaf's value is kept with: 8, 16 or 32
  double memory_gb = 16.0;      ///< most that samples and training may take, (0, 10^6] [10^9 bytes]

  void visit(OptionVisitor& visitor);
};

/// Memory that samples and training take at most, in bytes, for a number of samples, features and targets.
/// The samples themselves are most of it.
double training_memory(std::int64_t samples, int features, int targets,
                       const RegressionForestOptions& options);

/// Throws an Error where that is more than options.memory_gb; it says what would fit. Call it before the
/// samples are collected.
void check_training_memory(std::int64_t samples, int features, int targets,
                           const RegressionForestOptions& options);

/// Trains a forest. A leaf holds the mean of the targets of all samples of the tree that reach it.
/// `target_weights` multiply the targets in the scores (not in the leaves), one per target; none: all 1. The
/// result depends neither on the number of threads nor on the order of the samples. Throws an Error where no
/// sample is set or memory_gb does not suffice.
RegressionForest train_regression_forest(const TrainingSamples& samples,
                                         const RegressionForestOptions& options, const TrainingRun& run = {},
                                         std::span<const double> target_weights = {});

/// Trains the forest that one process would train from the samples of all workers, bit by bit. `samples` are
/// this worker's; they move between the workers. Their sample 0 has the number `first_number` among all,
/// which counts where two have the same contents. memory_gb is for each worker. Options, run (but for the
/// checkpoint, which worker 0 alone has) and weights are the same for all. Returns the forest to worker 0 and
/// nothing to the others. Throws as above; who throws has to tell the others.
std::optional<RegressionForest> train_regression_forest(WorkerGroup& workers, TrainingSamples& samples,
                                                        std::int64_t first_number,
                                                        const RegressionForestOptions& options,
                                                        const TrainingRun& run = {},
                                                        std::span<const double> target_weights = {});

}  // namespace knuckle
