// SPDX-License-Identifier: Apache-2.0
#include "knuckle/net/dense_inference.h"

#include "knuckle/net/dense_architecture.h"
#include "knuckle/net/layers/map_operations.h"
#include "knuckle/net/vote_aggregation.h"

namespace knuckle {
namespace {

EncoderDecoder::Maps maps_of(const NetworkOptions& options) {
  return {dense_shape(options), {options.patch.size_px, options.patch.size_px}};
}

}  // namespace

DenseInference::DenseInference(const NetworkWeights& weights)
    : options_(weights.options()),
      network_(dense_shape(options_), weights),
      pool_([options = options_] { return maps_of(options); }) {}

NetworkPrediction DenseInference::predict(const Image<float>& patch) const {
  return pool_.with_workspace([&](EncoderDecoder::Maps& maps) {
    copy_image(patch, maps.input);
    network_.apply(maps);
    return aggregate_votes(maps.maps, patch, options_.joint_count(), DenseMaps(options_),
                           options_.dense.kernel);
  });
}

}  // namespace knuckle
