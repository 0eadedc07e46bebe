// SPDX-License-Identifier: Apache-2.0
// Private to the module: this header shows LibTorch.
#pragma once

#include <memory>

#include "knuckle/segment/detector/detector_options.h"
#include "knuckle/training/encoder_decoder_module.h"
#include "knuckle/training/trainable_module.h"

namespace knuckle {

/// The network of a detector (docs/detector.md). Input: N x 2 x height x width, inverse depths and measured
/// shares. Output: N x kDetectorMaps x height / 4 x width / 4. Targets: N x hands x kHandNumbers.
///
/// Loss: the focal loss of a heat map of hands' centres (Lin et al. 2017, in the form of Zhou et al. 2019:
/// near a centre a wrong peak costs less), and around each centre the absolute errors of offset, inverse
/// depth and extent and the cross entropy of the side. Around hands that do not count no heat is wrong.
class DetectorNetwork final : public TrainableModule {
 public:
  explicit DetectorNetwork(const DetectorOptions& options);

  torch::Tensor forward(const torch::Tensor& inputs) override;
  torch::Tensor loss(const torch::Tensor& output, const torch::Tensor& inputs,
                     const torch::Tensor& targets) override;

 private:
  DetectorOptions options_;
  EncoderDecoderModule network_;
};

/// Builds the network with random weights that depend on `seed` alone.
std::shared_ptr<DetectorNetwork> make_detector_network(const DetectorOptions& options, std::uint64_t seed);

}  // namespace knuckle
