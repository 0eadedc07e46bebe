// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "knuckle/core/options.h"

namespace knuckle {

/// How trees are grown, whatever is split and predicted (Riegler et al. 2015, section 5).
struct TreeOptions {
  int max_depth = 25;           ///< edges from the root to the deepest leaf, [0, 64]
  int splits_per_node = 10000;  ///< candidate features tried in a node, [1, 10^6]
  int samples_per_node = 5000;  ///< random subset of a node's samples that scores them, [2, 65535]
  int min_leaf_samples = 5;     ///< no split leaves fewer of the scored samples on a side, [1, 10^6]
  int threshold_bins =
      32;  ///< bins of equal width that part a feature's values (fewer in small nodes), [2, 256]
  double bagging_fraction = 1.0;  ///< part of the samples that a tree sees, drawn without replacement, (0, 1]
  std::uint64_t seed = 1;

  void visit(OptionVisitor& visitor) {
    visitor.integer("max_depth", max_depth, closed(0, 64));
    visitor.integer("splits_per_node", splits_per_node, closed(1, 1e6));
    visitor.integer("samples_per_node", samples_per_node, closed(2, 65535));
    visitor.integer("min_leaf_samples", min_leaf_samples, closed(1, 1e6));
    visitor.integer("threshold_bins", threshold_bins, closed(2, 256));
    visitor.real("bagging_fraction", bagging_fraction, open_closed(0, 1));
    visitor.seed("seed", seed);
  }
};

}  // namespace knuckle
