// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include "knuckle/net/dense_architecture.h"
#include "knuckle/training/encoder_decoder_module.h"
#include "knuckle/training/network_module.h"

namespace knuckle {

/// Adaptive weighting regression (Huang et al. 2020) on a compact encoder-decoder.
///
/// At a quarter of the patch's resolution each pixel of the hand votes for every joint: a unit offset towards
/// it, its closeness (1 at the joint, 0 at `kernel` from it), and the vote's weight. A joint is the mean of
/// the votes, weighted by the softmax of the weights over the pixels. The loss is the smooth L1 distance of
/// the joints, and of the offsets and closenesses within the kernel's reach.
///
/// Output: N x 5J x h x h with h = size / 4; channels are offset u (of all joints), v, d, closeness, weight.
/// A network that tells sides, or hands, has one more for each (DenseMaps), whose mean over what is seen is
/// the logit of a right hand, of a hand. Its targets have a row more for each, whose first number is 1 for a
/// right hand (for a hand), 0 for a left one (for something else), NaN where that is not known.
class DenseNetwork final : public NetworkModule {
 public:
  explicit DenseNetwork(const NetworkOptions& options);

  torch::Tensor forward(const torch::Tensor& patches) override;
  torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& patches,
                     const torch::Tensor& targets) override;
  NetworkAnswer decode(const torch::Tensor& output, const torch::Tensor& patches) override;

 private:
  struct Votes;
  torch::Tensor joint_loss(const torch::Tensor& output, const torch::Tensor& patches,
                           const torch::Tensor& joints) const;
  /// The mean of a map over what is seen: N.
  torch::Tensor logits(const torch::Tensor& output, const torch::Tensor& patches, int map) const;
  /// The mean entropy of the answers to a question against those that are known.
  torch::Tensor question_loss(const torch::Tensor& logits, const torch::Tensor& answers) const;
  /// The loss in LibTorch's operations, for any device and precision: what `vote_loss` computes faster.
  torch::Tensor loss_by_operations(const torch::Tensor& output, const torch::Tensor& patches,
                                   const torch::Tensor& joints) const;
  Votes votes_of(const torch::Tensor& output, const torch::Tensor& patches) const;

  int joint_count_;
  DenseNetworkOptions options_;
  DenseMaps maps_;
  EncoderDecoderModule network_;
};

}  // namespace knuckle
