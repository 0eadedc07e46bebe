// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "knuckle/pipeline/pipeline.h"

namespace knuckle::python {

/// What Python's Pipeline is.
struct HeldPipeline {
  Pipeline pipeline;
  pybind11::object* function = nullptr;  ///< where it holds a function of the user's; null: it has none
};

}  // namespace knuckle::python
