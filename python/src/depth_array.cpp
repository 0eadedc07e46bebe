// SPDX-License-Identifier: Apache-2.0
#include "depth_array.h"

#include "arrays.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <fmt/format.h>
#include <pybind11/numpy.h>

#include "knuckle/core/error.h"
#include "knuckle/core/frame.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

/// A value that need not be aligned.
template <class T>
T value_at(const char* place, bool is_swapped) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), place, sizeof(T));
  if (is_swapped) std::ranges::reverse(bytes);
  return std::bit_cast<T>(bytes);
}

/// Inlined, so that the compiler makes vector code of the usual case: stride and byte order known.
template <class T>
[[gnu::always_inline]] inline void copy_row(const char* from, py::ssize_t stride, bool is_swapped,
                                            double unit_mm, std::span<float> to) {
  for (float& depth_mm : to) {
    const auto value = static_cast<float>(value_at<T>(from, is_swapped) * unit_mm);
    depth_mm = is_measured(value) ? value : 0.0f;
    from += stride;
  }
}

template <class T>
void copy_depths(const py::array& from, double unit_mm, Image<float>& to) {
  constexpr char kForeign = std::endian::native == std::endian::little ? '>' : '<';
  const bool is_swapped = from.dtype().byteorder() == kForeign;
  const py::ssize_t stride = from.strides(1);
  const bool is_plain = !is_swapped && stride == sizeof(T);
  const auto* row_start = static_cast<const char*>(from.data());
  for (int row = 0; row < to.height(); ++row, row_start += from.strides(0)) {
    if (is_plain) {
      copy_row<T>(row_start, sizeof(T), false, unit_mm, to.row(row));
    } else {
      copy_row<T>(row_start, stride, is_swapped, unit_mm, to.row(row));
    }
  }
}

using Copy = void (*)(const py::array&, double, Image<float>&);

/// How depths of that type are copied; null where they are none.
Copy copy_for(const py::dtype& type) {
  if (type.kind() == 'f' && type.itemsize() == 4) return copy_depths<float>;
  if (type.kind() == 'f' && type.itemsize() == 8) return copy_depths<double>;
  if (type.kind() == 'u' && type.itemsize() == 2) return copy_depths<std::uint16_t>;
  return nullptr;
}

void check_shape(const py::array& depth, const Camera& camera) {
  if (depth.ndim() != 2) fail("depth: has {} dimensions, expected (rows, columns)", depth.ndim());
  if (depth.shape(0) != camera.height || depth.shape(1) != camera.width) {
    fail("depth: has {} rows and {} columns, the camera {} and {}", depth.shape(0), depth.shape(1),
         camera.height, camera.width);
  }
}

void check_unit(double unit_mm) {
  if (!(unit_mm > 0.0 && unit_mm <= 1e6))
    fail("depth_unit_mm: is {}, expected a number in (0, 1e6]", unit_mm);
}

std::string type_name_of(const py::handle& object) {
  return py::str(py::type::handle_of(object).attr("__name__"));
}

}  // namespace

Image<float> depth_image(const py::object& depth, const Camera& camera, double unit_mm) {
  if (!py::isinstance<py::array>(depth)) {
    throw py::type_error(
        fmt::format("depth: expected a numpy array (rows, columns), found {}", type_name_of(depth)));
  }
  auto array = py::reinterpret_borrow<py::array>(depth);
  const Copy copy = copy_for(array.dtype());
  if (copy == nullptr) {
    throw py::type_error(fmt::format("depth: expected an array of float32, float64 or uint16, found {}",
                                     std::string(py::str(array.dtype()))));
  }
  check_shape(array, camera);
  check_unit(unit_mm);
  if (is_masked(array)) array = array.attr("filled")(0);
  Image<float> image(camera.width, camera.height);
  copy(array, unit_mm, image);
  return image;
}

}  // namespace knuckle::python
