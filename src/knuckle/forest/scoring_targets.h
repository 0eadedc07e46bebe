// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/shared_places.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle {

/// What splits are scored with: the targets, weighted, projected to their principal components where they
/// have more dimensions than asked for, and rounded to whole numbers in [-16383, 16383] of one common step.
/// Sums of whole numbers are exact, so a score depends neither on the order of the samples nor on threads.
struct ScoringTargets {
  int dimensions = 0;                ///< of a row
  float step = 1.0F;                 ///< a value is `step` times the whole number
  double captured_variance = 1.0;    ///< part of the weighted targets' variance that the projection keeps
  std::vector<std::int16_t> values;  ///< one row per sample of the set; rows never set are 0

  const std::int16_t* row(std::size_t sample) const { return values.data() + sample * dimensions; }
};

/// The samples in canonical order, or this worker's part of them.
struct SamplesInOrder {
  std::span<const std::uint32_t> order;
  WorkerGroup* workers = nullptr;  ///< with whom they are shared; nullptr: nobody
  SumOfWorkers count = {};         ///< where they are shared: samples of all workers, and of those before
};

/// `weights` multiply the targets, one per target, or none for all 1. Sums are made in one order, whoever has
/// which samples: the bits do not depend on threads or workers.
ScoringTargets make_scoring_targets(const TrainingSamples& samples, const SamplesInOrder& order,
                                    std::span<const double> weights, int most_dimensions);

}  // namespace knuckle
