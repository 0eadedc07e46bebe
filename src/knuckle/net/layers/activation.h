// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks.
#pragma once

#include "knuckle/net/layers/float_lanes.h"

namespace knuckle {

/// What follows a layer.
enum class Activation { relu, linear };

/// activation(value + added); `added` may be null.
inline FloatLanes activated(FloatLanes value, const float* added, Activation activation) {
  if (added != nullptr) value += load_lanes(added);
  return activation == Activation::relu ? larger_lanes(FloatLanes{}, value) : value;
}

}  // namespace knuckle
