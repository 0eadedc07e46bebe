// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "knuckle/core/landmarks.h"

namespace knuckle::python {

/// The names of a convention's landmarks, in its order.
pybind11::list landmark_names(const Convention& convention);

}  // namespace knuckle::python
