// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "knuckle/net/layers/encoder_decoder_shape.h"
#include "knuckle/net/network_options.h"

namespace knuckle {

inline constexpr int kMapsPerJoint = 5;  ///< offset u, v, d; closeness; weight
/// Spread of the votes at which the confidence falls to 1 / e: 19 mm in a cube of 250 mm.
inline constexpr double kSpreadScale = 0.15;

/// Which of a network's maps tells what: those of all joints come first, then that of sides, then that of
/// hands.
struct DenseMaps {
  explicit DenseMaps(const NetworkOptions& options);

  int count = 0;
  std::optional<int> side;  ///< its mean over the hand is the logit of a right hand
  std::optional<int> hand;  ///< its mean is the logit of a hand
};

/// The channels of the architecture `dense`.
EncoderDecoderShape dense_shape(const NetworkOptions& options);

/// Its arrays, as `network_arrays` has them.
std::vector<NetworkArray> dense_arrays(const NetworkOptions& options);

}  // namespace knuckle
