// SPDX-License-Identifier: Apache-2.0
// Private to the networks' modules.
#pragma once

#include <vector>

#include "knuckle/net/layers/convolution.h"
#include "knuckle/net/layers/encoder_decoder_shape.h"

namespace knuckle {

/// The encoder-decoder in use, its batch norms folded into the convolutions before them.
class EncoderDecoder {
 public:
  /// Height and width of an input: multiples of kCoarsestStride [px].
  struct Size {
    int height;
    int width;
  };

  /// All maps of one look. The caller writes `input`; `maps` comes out.
  struct Maps {
    Maps(const EncoderDecoderShape& shape, const Size& size);
    FeatureMap input, stem;
    std::vector<FeatureMap> stages;  // features at a quarter, an eighth, a sixteenth
    std::vector<FeatureMap> inner;   // of the same sizes: inside of residual blocks
    FeatureMap lateral2, smooth2, lateral1, smooth1, maps;
  };

  /// `weights` has the arrays of `encoder_decoder_arrays(shape)`.
  EncoderDecoder(const EncoderDecoderShape& shape, const WeightArrays& weights);

  /// From `input` to `maps`.
  void apply(Maps& maps) const;

 private:
  struct Block {
    Convolution first, second;
  };
  struct Stage {
    Convolution down;
    std::vector<Block> blocks;
  };

  void encode(Maps& maps) const;
  void decode(Maps& maps) const;

  Convolution stem_;
  std::vector<Stage> stages_;
  Convolution lateral2_, smooth2_, lateral1_, smooth1_, head_;
};

}  // namespace knuckle
