// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "knuckle/net/layers/encoder_decoder_shape.h"
#include "knuckle/net/network_options.h"

namespace knuckle {

inline constexpr int kMapsPerJoint = 5;  ///< offset u, v, d; closeness; weight
/// Spread of the votes at which the confidence falls to 1 / e: 19 mm in a cube of 250 mm.
inline constexpr double kSpreadScale = 0.15;

/// The channels of the architecture `dense`; the map that tells sides comes behind those of all joints.
EncoderDecoderShape dense_shape(const NetworkOptions& options);

/// Its arrays, as `network_arrays` has them.
std::vector<NetworkArray> dense_arrays(const NetworkOptions& options);

}  // namespace knuckle
