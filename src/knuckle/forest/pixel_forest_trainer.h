// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/depth_offsets.h"
#include "knuckle/forest/forest_growth.h"
#include "knuckle/forest/pixel_forest.h"
#include "knuckle/forest/pixel_samples.h"
#include "knuckle/forest/split_options.h"

namespace knuckle {

/// Training of a forest that classifies pixels (Riegler et al. 2015, section 5.1: 4 trees of depth 25).
struct PixelForestOptions {
  int trees = 4;  ///< [1, 250]
  TreeOptions tree{.threshold_bins = 9};
  OffsetOptions offsets;
  double memory_gb = 16.0;  ///< most that samples and training may take, (0, 10^6] [10^9 bytes]

  void visit(OptionVisitor& visitor);
};

/// Bytes that training takes at most for so many samples, beside what PixelSamples::bytes tells.
double training_memory(std::int64_t samples, const PixelForestOptions& options);

/// Throws an Error where samples of `image_bytes` and their training take more than options.memory_gb. While
/// samples are collected, call it with what there is: it says how many of the images would fit.
void check_training_memory(double image_bytes, std::int64_t images, std::int64_t samples,
                           const PixelForestOptions& options);

/// Trains a forest. A leaf holds the part of class 1 among all samples of the tree that reach it, in 8 bits.
/// The result depends neither on the number of threads nor on the order of the images. Throws an Error where
/// there is no sample, all are of one class, or memory_gb does not suffice.
PixelForest train_pixel_forest(const PixelSamples& samples, const PixelForestOptions& options,
                               const TrainingRun& run = {});

/// Trains the forest that one process would train from the samples of all workers, bit by bit; see
/// train_regression_forest. Images move once, to where the order of training has them. `first_number` is the
/// number of this worker's image 0 among all.
std::optional<PixelForest> train_pixel_forest(WorkerGroup& workers, PixelSamples& samples,
                                              std::int64_t first_number, const PixelForestOptions& options,
                                              const TrainingRun& run = {});

}  // namespace knuckle
