// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <torch/types.h>

namespace knuckle {

/// Where `dense`'s loss turns from square to linear [halves of the cube's side].
inline constexpr double kVoteLossSmoothness = 0.01;

/// The loss of adaptive weighting regression (Huang et al. 2020), and its way back, in one pass through the
/// cells that are hand: the mean smooth L1 distance of the joints, and `dense_weight` times that of offsets
/// and of closenesses within `kernel` of a joint.
struct VoteLossOptions {
  double kernel = 0.8;
  double dense_weight = 0.5;
};

/// On a processor, in single precision. `output`: N x 5J x h x h as DenseNetwork has it; `points`: N x 3 x h
/// x h, where each cell is, background at or above kCubeBackground; `joints`: N x J x 3, NaN where not known.
torch::Tensor vote_loss(const torch::Tensor& output, const torch::Tensor& points, const torch::Tensor& joints,
                        const VoteLossOptions& options);

}  // namespace knuckle
