// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "knuckle/core/camera.h"
#include "knuckle/core/image.h"

namespace knuckle::python {

/// A numpy array (rows, columns) of float32, float64 or uint16, of any strides and byte order, as a depth
/// image in millimetres: `unit_mm` times its values, 0 (not measured) where that is not finite, not above 0
/// or masked (numpy.ma). The one copy of a frame that is made; the array may change or be freed afterwards.
/// Throws a TypeError where it is no such array, an Error where it has not the camera's size or the unit is
/// not in (0, 1e6].
Image<float> depth_image(const pybind11::object& depth, const Camera& camera, double unit_mm);

}  // namespace knuckle::python
