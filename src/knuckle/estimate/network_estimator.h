// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/options.h"
#include "knuckle/estimate/estimator.h"
#include "knuckle/net/pose_network.h"

namespace knuckle {

/// How a network is used: keys of the `[estimator]` table.
struct NetworkEstimatorOptions {
  /// Looks at each hand, [1, 5]; all but the first around the mean of the joints that were found: a learned
  /// refinement of the centre, as in DeepPrior++ (Oberweger and Lepetit 2017).
  int passes = 2;

  void visit(OptionVisitor& visitor) { visitor.integer("passes", passes, closed(1, 5)); }
};

/// The mean confidence from which on a pose of such a network may be taken for that of a hand, or 0. Of
/// `dense`: hands have 0.50 and more, other things 0.36 and less, nearly all (docs/results.md).
double sure_confidence_of(const NetworkOptions& network);

/// Pose by a convolutional network. The confidence of a joint says how well the pixels' votes agree
/// (`dense`), or how high the heat map's peak is; direct regression gives none.
class NetworkEstimator final : public Estimator {
 public:
  /// Throws an Error where an option is out of range.
  NetworkEstimator(PoseNetwork network, const NetworkEstimatorOptions& options);

  Convention convention() const override { return convention_; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return options_.passes; }
  double sure_confidence() const override { return sure_confidence_of(network_.options()); }
  /// Throws an Error where the patch has another size or a pixel is not finite.
  PatchPose estimate(const HandPatch& patch) const override;

 private:
  PoseNetwork network_;
  NetworkEstimatorOptions options_;
  Convention convention_;
  PatchExtractor patches_;
};

}  // namespace knuckle
