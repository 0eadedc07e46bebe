// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include "interpreter_lock.h"

#include <cmath>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "knuckle/core/error.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

std::vector<py::ssize_t> shape_of(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

/// The array that numpy makes of values, of any type where none is given; null where it raised.
PyObject* array_from(const py::object& values, py::object type, int flags) {
  return in_python([&] {
    return py::detail::npy_api::get().PyArray_FromAny_(values.ptr(), type.release().ptr(), 0, 0, flags,
                                                       nullptr);
  });
}

/// Throws what was raised: within a TypeError, as its cause, or alone where it is none of Python's
/// Exceptions.
[[noreturn]] void throw_raised(const std::string& message) {
  py::error_already_set raised;
  if (!raised.matches(PyExc_Exception)) throw raised;
  py::raise_from(raised, PyExc_TypeError, message.c_str());
  throw py::error_already_set();
}

/// Rotations that users write down are rounded.
constexpr double kRigidTolerance = 1e-6;

bool is_rigid(const Eigen::Matrix4d& matrix) {
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const bool has_last_row = matrix.row(3) == Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0);
  return matrix.allFinite() && has_last_row && rotation.determinant() > 0.0 &&
         (rotation * rotation.transpose()).isIdentity(kRigidTolerance);
}

}  // namespace

bool is_masked(const py::array& array) {
  const bool is_plain = Py_TYPE(array.ptr()) == py::detail::npy_api::get().PyArray_Type_;
  return !is_plain && py::isinstance(array, py::module_::import("numpy.ma").attr("MaskedArray"));
}

py::array_t<double> real_numbers(const py::object& values, std::string_view what, std::string_view expected) {
  const std::string message = fmt::format("{}: expected {}", what, expected);
  auto array = py::reinterpret_steal<py::array>(array_from(values, py::object(), 0));
  if (!array) throw_raised(message);
  if (array.dtype().kind() == 'c') throw py::type_error(message + ", found complex ones");
  if (is_masked(array)) array = array.attr("astype")(py::dtype::of<double>()).attr("filled")(kNaN);
  const int as_values =
      py::array::c_style | py::array::forcecast | py::detail::npy_api::NPY_ARRAY_ENSUREARRAY_;
  const auto numbers =
      py::reinterpret_steal<py::array_t<double>>(array_from(array, py::dtype::of<double>(), as_values));
  if (!numbers) throw_raised(message);
  return numbers;
}

py::array_t<double> doubles(const py::object& values, const std::vector<py::ssize_t>& shape,
                            std::string_view what) {
  const auto array =
      real_numbers(values, what, fmt::format("numbers, an array of the shape ({})", fmt::join(shape, ", ")));
  if (shape_of(array) != shape) {
    fail("{}: has the shape ({}), expected ({})", what, fmt::join(shape_of(array), ", "),
         fmt::join(shape, ", "));
  }
  return array;
}

py::array_t<double> array_of(std::span<const Point3> points) {
  py::array_t<double> array({std::ssize(points), py::ssize_t{3}});
  auto values = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < std::ssize(points); ++i) {
    for (int k = 0; k < 3; ++k) values(i, k) = points[static_cast<std::size_t>(i)][k];
  }
  return array;
}

py::array_t<double> array_of(std::span<const PixelPoint> points) {
  py::array_t<double> array({std::ssize(points), py::ssize_t{2}});
  auto values = array.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < std::ssize(points); ++i) {
    values(i, 0) = points[static_cast<std::size_t>(i)].u;
    values(i, 1) = points[static_cast<std::size_t>(i)].v;
  }
  return array;
}

py::array_t<double> matrix_of(const RigidTransform& transform) {
  py::array_t<double> array({4, 4});
  auto values = array.mutable_unchecked<2>();
  const Eigen::Matrix4d matrix = transform.matrix();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) values(row, column) = matrix(row, column);
  }
  return array;
}

RigidTransform transform_from(const py::object& values, std::string_view what) {
  const auto array = doubles(values, {4, 4}, what);
  Eigen::Matrix4d matrix;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) matrix(row, column) = array.at(row, column);
  }
  if (!is_rigid(matrix))
    fail("{}: expected a rotation and a shift, as a (4, 4) matrix with the last row 0, 0, 0, 1", what);
  RigidTransform transform = RigidTransform::Identity();
  transform.matrix() = matrix;
  return transform;
}

}  // namespace knuckle::python
