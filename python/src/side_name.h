// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "knuckle/core/frame.h"

namespace knuckle::python {

/// "right" or "left".
inline const char* side_name(HandSide side) {
  return side == HandSide::left ? "left" : "right";
}

}  // namespace knuckle::python
