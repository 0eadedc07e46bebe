// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "knuckle/core/worker_group.h"
#include "knuckle/forest/shared_places.h"
#include "knuckle/forest/training_samples.h"

namespace knuckle {

/// A leaf of a tree, and this worker's samples of it.
struct SharedLeaf {
  std::span<const std::uint32_t> samples;
  NodeShare share;
};

/// The mean of the targets of all samples that reach each leaf, one row per leaf, for worker 0; nothing for
/// the others. Targets are added up in the order of the tree's list of samples, by one worker after another
/// where several have samples of a leaf: the bits are those of one process.
std::vector<float> shared_leaf_means(WorkerGroup& workers, const TrainingSamples& samples,
                                     std::span<const SharedLeaf> leaves);

/// How many of the samples that reach a leaf are of class 1.
struct ClassCount {
  std::int64_t ones = 0;
  std::int64_t all = 0;
};
/// One count per leaf for worker 0; nothing for the others. `labels` has the class of each sample, 0 or 1.
std::vector<ClassCount> shared_class_counts(WorkerGroup& workers, std::span<const std::uint8_t> labels,
                                            std::span<const SharedLeaf> leaves);

}  // namespace knuckle
