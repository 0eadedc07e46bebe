// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/frame.h"

#include "arrays.h"
#include "bindings.h"
#include "depth_array.h"
#include "side_name.h"

#include <optional>
#include <string>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/text.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc = R"(A depth image with what is known about it.

Frames come from sources (open_source, render), or are made of an array:
Frame(depth, camera, depth_unit_mm=1.0, time_s=None, name="", sequence=0), with depth and unit as in
Pipeline.estimate, whose pixels are copied once; a Tracker wants time_s.

The arrays show the frame's own memory: nothing is copied, and writing to them changes the frame.)";

Frame frame_from(const py::object& depth, const Camera& camera, double depth_unit_mm,
                 std::optional<double> time_s, std::string name, int sequence) {
  Frame frame;
  frame.depth_mm = depth_image(depth, camera, depth_unit_mm);
  frame.camera = camera;
  frame.time_s = time_s;
  frame.name = std::move(name);
  frame.sequence = sequence;
  return frame;
}

/// A property that shows an image of the frame.
template <class T>
auto show(Image<T> Frame::*image) {
  return [image](const py::object& self) { return view_of(self.cast<const Frame&>().*image, self); };
}

py::object truth_mm(const Frame& frame) {
  if (!frame.truth) return py::none();
  return array_of(hand_record(*frame.truth, Projection(frame.camera), PixelOrigin::centre).landmarks_mm);
}

py::object truth_px(const Frame& frame) {
  if (!frame.truth) return py::none();
  return array_of(hand_record(*frame.truth, Projection(frame.camera), PixelOrigin::centre).landmarks_px);
}

py::object convention_of(const Frame& frame) {
  if (!frame.truth) return py::none();
  return py::str(std::string(frame.truth->convention.name));
}

py::object side_of(const Frame& frame) {
  if (!frame.side) return py::none();
  return py::str(side_name(*frame.side));
}

/// Names may be those of files, whose bytes need not be UTF-8: they become what Python makes of such files'
/// names.
py::str name_of_frame(const Frame& frame) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeFSDefaultAndSize(frame.name.data(), std::ssize(frame.name)));
}

std::string text_of(const Frame& frame) {
  return fmt::format("<knuckle.Frame '{}', {} x {} pixels>", printable(frame.name), frame.camera.width,
                     frame.camera.height);
}

}  // namespace

void add_frame(py::module_& module) {
  py::class_<Frame>(module, "Frame", kDoc)
      .def(py::init(&frame_from), py::arg("depth"), py::arg("camera"), py::kw_only(),
           py::arg("depth_unit_mm") = 1.0, py::arg("time_s") = py::none(), py::arg("name") = "",
           py::arg("sequence") = 0)
      .def_property_readonly("depth_mm", show(&Frame::depth_mm),
                             "(rows, columns) float32, distance along z [mm]; 0: no measurement.")
      .def_property_readonly(
          "infrared", show(&Frame::infrared),
          "(rows, columns) uint16, in the sensor's own unit; None where the source has none.")
      .def_property_readonly(
          "mask", show(&Frame::mask),
          "Truth: (rows, columns) uint8, 1 where a pixel is hand, else 0; None where not known.")
      .def_property_readonly(
          "camera", [](const Frame& frame) { return frame.camera; }, "The frame's Camera.")
      .def_property_readonly(
          "truth_mm", &truth_mm,
          "Truth: (J, 3) landmarks in camera coordinates [mm], NaN where one is not known; or None.")
      .def_property_readonly("truth_px", &truth_px,
                             "Truth: (J, 2) landmarks in the image, column and row [px]; or None.")
      .def_property_readonly("convention", &convention_of,
                             "The convention of the truth; None where there is none.")
      .def_property_readonly("side", &side_of, "Truth: right or left; None where not known.")
      .def_property_readonly(
          "time_s", [](const Frame& frame) { return frame.time_s; },
          "When it was taken [s], any zero; or None.")
      .def_property_readonly(
          "sequence", [](const Frame& frame) { return frame.sequence; },
          "Number of the source's sequence, from 0 on.")
      .def_property_readonly("name", &name_of_frame, "Unique in its source.")
      .def("__reduce__", &refuse_to_pickle)
      .def("__repr__", &text_of);
}

}  // namespace knuckle::python
