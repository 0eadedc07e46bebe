// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/estimate/network_estimator.h"
#include "knuckle/net/onnx_network.h"

namespace knuckle {

/// A network of ours as `knuckle export` writes it, run by another engine: the same answers as those of
/// NetworkEstimator but for roundings.
class ExportedEstimator final : public Estimator {
 public:
  /// `network` is what the file's metadata say. Throws an Error that names the file where its inputs or
  /// outputs are not those of such a network, and where an option is out of range.
  ExportedEstimator(OnnxNetwork file, NetworkOptions network, const NetworkEstimatorOptions& options);

  Convention convention() const override { return convention_; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return options_.passes; }
  double sure_confidence() const override { return sure_confidence_of(network_); }
  /// Throws an Error where the patch has another size.
  PatchPose estimate(const HandPatch& patch) const override;

 private:
  /// The place of an output, which must have that shape; -1 where it is missing and may be.
  int output(const std::string& name, const OnnxShape& shape, bool is_required) const;
  void find_outputs();

  OnnxNetwork file_;
  NetworkOptions network_;
  NetworkEstimatorOptions options_;
  Convention convention_;
  PatchExtractor patches_;
  int landmarks_ = -1, confidence_ = -1, heat_maps_ = -1, depth_bins_ = -1, right_hand_ = -1, hand_ = -1;
};

}  // namespace knuckle
