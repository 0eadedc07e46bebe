// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/dense_architecture.h"

namespace knuckle {

DenseMaps::DenseMaps(const NetworkOptions& options) : count(kMapsPerJoint * options.joint_count()) {
  if (options.dense.tells_side) side = count++;
  if (options.dense.tells_hand) hand = count++;
}

EncoderDecoderShape dense_shape(const NetworkOptions& options) {
  const DenseNetworkOptions& dense = options.dense;
  return {.inputs = 1,
          .stem = dense.stem_channels,
          .quarter = dense.quarter_channels,
          .eighth = dense.eighth_channels,
          .sixteenth = dense.sixteenth_channels,
          .head = dense.head_channels,
          .blocks = dense.blocks,
          .maps = DenseMaps(options).count};
}

std::vector<NetworkArray> dense_arrays(const NetworkOptions& options) {
  return encoder_decoder_arrays(dense_shape(options));
}

}  // namespace knuckle
