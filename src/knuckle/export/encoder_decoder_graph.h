// SPDX-License-Identifier: Apache-2.0
// Private to the module.
#pragma once

#include <string>

#include "knuckle/export/graph_builder.h"
#include "knuckle/net/layers/encoder_decoder_shape.h"
#include "knuckle/net/layers/weight_arrays.h"

namespace knuckle {

/// Adds a batch norm of a network's file with its numbers as they are. Returns its name.
std::string add_norm(GraphBuilder& graph, const WeightArrays& weights, const std::string& name,
                     const std::string& input);

/// Adds the encoder-decoder (net/layers/encoder_decoder.h) without its head. Returns the name of the features
/// that the head reads: 1 x shape.head x a quarter of the input's rows and columns.
std::string add_encoder_decoder(GraphBuilder& graph, const EncoderDecoderShape& shape,
                                const WeightArrays& weights, const std::string& input);

/// A part of the head's maps.
struct MapRange {
  int first;
  int count;
};

/// Adds the head for these maps alone. Returns its name.
std::string add_head(GraphBuilder& graph, const EncoderDecoderShape& shape, const WeightArrays& weights,
                     const std::string& features, const MapRange& maps, const std::string& name);

}  // namespace knuckle
