// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include "knuckle/net/heat_map.h"
#include "knuckle/training/paper_network.h"

namespace knuckle {

/// Heat maps (Riegler et al. 2015, sections 3.1 and 3.2): a map of u and v for each joint, and in
/// `heatmap25d` bins of its depth, d from -1 to 1. In `heatmap2d` the depth is looked up in the patch.
///
/// Output: N x (J cells^2 [+ J bins]). The targets are Gaussians of height 1 around the joints; the loss is
/// the squared error, summed over a joint's cells and bins, the mean over the joints that are known.
class HeatMapNetwork final : public PaperNetwork {
 public:
  explicit HeatMapNetwork(const NetworkOptions& options);

  torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& patches,
                     const torch::Tensor& joints) override;
  /// The confidence of a joint is the height of its map's peak, cut to [0, 1].
  NetworkAnswer decode(const torch::Tensor& output, const torch::Tensor& patches) override;

  /// The output that says `joints` (N x J x 3, all known) without error.
  torch::Tensor targets(const torch::Tensor& joints) const;

 private:
  NetworkOptions options_;
  int64_t joint_count_;
  int64_t bins_;  // of depth a joint; 0 where it is looked up
  HeatMapGrid grid_;
};

}  // namespace knuckle
