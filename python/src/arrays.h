// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <pybind11/numpy.h>

#include "knuckle/core/image.h"
#include "knuckle/core/pose.h"
#include "knuckle/core/transform.h"
#include "knuckle/data/frame_record.h"

namespace knuckle::python {

bool is_masked(const pybind11::array& array);

/// An array of doubles, NaN where a masked array (numpy.ma) is masked, from anything that numpy can make one
/// of. Throws a TypeError where it cannot, with numpy's own exception as its cause, or where numbers are
/// complex; it calls them `what` and says that `expected` was expected.
pybind11::array_t<double> real_numbers(const pybind11::object& values, std::string_view what,
                                       std::string_view expected);

/// The same of this shape. Throws an Error, too, where the shape differs.
pybind11::array_t<double> doubles(const pybind11::object& values, const std::vector<pybind11::ssize_t>& shape,
                                  std::string_view what);

/// (N, 3) [mm]; NaN where a point is not known.
pybind11::array_t<double> array_of(std::span<const Point3> points);
/// (N, 2) [px]; NaN where a point is not known.
pybind11::array_t<double> array_of(std::span<const PixelPoint> points);

/// A rigid transform as a (4, 4) matrix, and back. Throws an Error, which calls it `what`, where the matrix
/// is not one.
pybind11::array_t<double> matrix_of(const RigidTransform& transform);
RigidTransform transform_from(const pybind11::object& matrix, std::string_view what);

/// The pixels of an image as an array (rows, columns) without copying: `owner` is the Python object that
/// holds the image, and is kept alive by the array. None where the image is empty.
template <class T>
pybind11::object view_of(const Image<T>& image, const pybind11::object& owner) {
  if (image.empty()) return pybind11::none();
  return pybind11::array_t<T>({image.height(), image.width()}, image.data(), owner);
}

}  // namespace knuckle::python
