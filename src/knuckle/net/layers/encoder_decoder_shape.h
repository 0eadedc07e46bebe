// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "knuckle/net/layers/weight_arrays.h"

namespace knuckle {

inline constexpr int kEncoderStages = 3;    ///< at a quarter, an eighth and a sixteenth of the input
inline constexpr int kCoarsestStride = 16;  ///< input pixels per pixel of the coarsest stage
inline constexpr int kMapStride = 4;        ///< input pixels per pixel of the maps that come out

/// Channels of the encoder-decoder that our own networks are made of: a stem at half the input's resolution,
/// stages at a quarter, an eighth and a sixteenth, two steps up again, each with the stage's own features
/// added, and a head of maps at a quarter.
struct EncoderDecoderShape {
  int inputs = 1;
  int stem = 16;
  int quarter = 32;
  int eighth = 64;
  int sixteenth = 128;
  int head = 64;   ///< before the maps
  int blocks = 1;  ///< residual blocks per stage
  int maps = 1;
};

/// A convolution (padded to keep the size, without bias) with its batch norm.
struct EncoderDecoderUnit {
  std::string name;
  int inputs;
  int outputs;
  int kernel;
  int stride;
};

/// All units but the head, which has a bias and no norm.
std::vector<EncoderDecoderUnit> encoder_decoder_units(const EncoderDecoderShape& shape);

/// The arrays that it consists of.
std::vector<NetworkArray> encoder_decoder_arrays(const EncoderDecoderShape& shape);

}  // namespace knuckle
