// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>
#include <vector>

#include "knuckle/net/layers/encoder_decoder_shape.h"
#include "knuckle/training/layers.h"

namespace knuckle {

/// The encoder-decoder (knuckle/net/layers/encoder_decoder_shape.h) as layers of the network that owns them,
/// so that their weights have the names that files have.
class EncoderDecoderModule {
 public:
  /// Registers the layers with `owner`.
  EncoderDecoderModule(torch::nn::Module& owner, const EncoderDecoderShape& shape);

  /// N x inputs x height x width to N x maps x height / 4 x width / 4. The maps come in single precision (or
  /// that of the head), whatever the type of the input: they say fractions of a millimetre.
  torch::Tensor forward(const torch::Tensor& inputs);

  torch::Tensor head_bias() { return head_->bias; }

 private:
  std::vector<std::shared_ptr<ConvolutionUnit>> down_;               // stem, and one per stage
  std::vector<std::vector<std::shared_ptr<ResidualBlock>>> blocks_;  // per stage
  std::vector<std::shared_ptr<ConvolutionUnit>> lateral_;
  std::vector<std::shared_ptr<ConvolutionUnit>> smooth_;
  torch::nn::Conv2d head_{nullptr};
};

}  // namespace knuckle
