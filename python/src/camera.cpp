// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/camera.h"

#include "bindings.h"
#include "checked_text.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "knuckle/core/error.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc = R"(Intrinsics of a depth camera; cannot be changed once made.

fx, fy: focal lengths [px] (orthographic: [px/mm]), 1e-6 to 1e9 in size; fy is negative where y points up.
cx, cy: principal point [px]; the centre of the first pixel is (0, 0).
width, height: of the image [px], 1 to 16384.
distortion: up to 8 coefficients in OpenCV's order: k1, k2, p1, p2, k3, k4, k5, k6.
model: "projective" or "orthographic".

Raises knuckle.Error where a value is impossible.)";

CameraModel model_from_name(const std::string& name) {
  if (name == "projective") return CameraModel::projective;
  if (name == "orthographic") return CameraModel::orthographic;
  fail("camera: model is '{}', expected projective or orthographic", name);
}

std::string name_of(CameraModel model) {
  return model == CameraModel::projective ? "projective" : "orthographic";
}

std::array<double, 8> coefficients_from(const std::vector<double>& given) {
  std::array<double, 8> coefficients{};
  if (given.size() > coefficients.size()) {
    fail("camera: distortion has {} coefficients, expected at most {}", given.size(), coefficients.size());
  }
  std::ranges::copy(given, coefficients.begin());
  return coefficients;
}

Camera camera_from(double fx, double fy, double cx, double cy, int width, int height,
                   const std::vector<double>& distortion, const std::string& model) {
  const Camera camera{model_from_name(checked_text(model, "model")),
                      width,
                      height,
                      fx,
                      fy,
                      cx,
                      cy,
                      coefficients_from(distortion)};
  check(camera);
  return camera;
}

py::tuple parts_of(const Camera& camera) {
  return py::make_tuple(camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height,
                        py::tuple(py::cast(camera.distortion)), name_of(camera.model));
}

std::string text_of(const Camera& camera) {
  return fmt::format("knuckle.Camera(fx={}, fy={}, cx={}, cy={}, width={}, height={}{}{})", camera.fx,
                     camera.fy, camera.cx, camera.cy, camera.width, camera.height,
                     camera.is_distorted() ? ", distortion=..." : "",
                     camera.model == CameraModel::orthographic ? ", model='orthographic'" : "");
}

}  // namespace

void add_camera(py::module_& module) {
  py::class_<Camera>(module, "Camera", kDoc)
      .def(py::init(&camera_from), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("width"), py::arg("height"), py::arg("distortion") = py::tuple(),
           py::arg("model") = "projective")
      .def_readonly("fx", &Camera::fx, "Focal length [px]; orthographic: [px/mm].")
      .def_readonly("fy", &Camera::fy, "Focal length down the image [px]; negative where y points up.")
      .def_readonly("cx", &Camera::cx, "Column of the principal point [px].")
      .def_readonly("cy", &Camera::cy, "Row of the principal point [px].")
      .def_readonly("width", &Camera::width, "Columns of the image.")
      .def_readonly("height", &Camera::height, "Rows of the image.")
      .def_property_readonly(
          "distortion", [](const Camera& camera) { return py::tuple(py::cast(camera.distortion)); },
          "8 coefficients in OpenCV's order: k1, k2, p1, p2, k3, k4, k5, k6.")
      .def_property_readonly(
          "model", [](const Camera& camera) { return name_of(camera.model); }, "projective or orthographic.")
      .def(
          "__eq__", [](const Camera& camera, const Camera& other) { return camera == other; },
          py::is_operator())
      .def("__hash__", [](const Camera& camera) { return py::hash(parts_of(camera)); })
      .def("__repr__", &text_of)
      .def("__reduce__", [](const py::object& self) {
        return py::make_tuple(py::type::of(self), parts_of(self.cast<const Camera&>()));
      });
}

}  // namespace knuckle::python
