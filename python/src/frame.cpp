// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/frame.h"

#include "arrays.h"
#include "bindings.h"
#include "depth_array.h"
#include "side_name.h"

#include <optional>
#include <string>
#include <vector>

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

py::object landmarks_mm(const HandPose& pose, const Camera& camera) {
  return array_of(hand_record(pose, Projection(camera), PixelOrigin::centre).landmarks_mm);
}

py::object landmarks_px(const HandPose& pose, const Camera& camera) {
  return array_of(hand_record(pose, Projection(camera), PixelOrigin::centre).landmarks_px);
}

py::object truth_mm(const Frame& frame) {
  return frame.truth ? landmarks_mm(*frame.truth, frame.camera) : py::none();
}

py::object truth_px(const Frame& frame) {
  return frame.truth ? landmarks_px(*frame.truth, frame.camera) : py::none();
}

constexpr const char* kHandDoc = "The truth about one of the hands in a frame.";

/// The truth about a hand, and the camera that saw it.
struct SeenHand {
  HandTruth truth;
  Camera camera;
};

std::vector<SeenHand> hands_of(const Frame& frame) {
  std::vector<SeenHand> hands;
  for (const HandTruth& hand : frame.hands) hands.push_back({hand, frame.camera});
  return hands;
}

const char* name_of(Occluder occluder) {
  switch (occluder) {
    case Occluder::none:
      return "none";
    case Occluder::own_hand:
      return "own_hand";
    case Occluder::other_hand:
      return "other_hand";
    case Occluder::person:
      return "person";
    case Occluder::object:
      return "object";
    case Occluder::border:
      return "border";
  }
  return "none";
}

std::vector<std::string> occluders_of(const SeenHand& hand) {
  std::vector<std::string> names;
  for (const Occluder occluder : hand.truth.occluders) names.emplace_back(name_of(occluder));
  return names;
}

std::string text_of_hand(const SeenHand& hand) {
  return fmt::format("<knuckle.TrueHand {}, {:.0f} % of it visible>", side_name(hand.truth.side),
                     100.0 * hand.truth.visible_share);
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

void add_true_hand(py::module_& module) {
  py::class_<SeenHand>(module, "TrueHand", kHandDoc)
      .def_property_readonly(
          "side", [](const SeenHand& hand) { return side_name(hand.truth.side); }, "right or left.")
      .def_property_readonly(
          "truth_mm", [](const SeenHand& hand) { return landmarks_mm(hand.truth.pose, hand.camera); },
          "(J, 3) landmarks in camera coordinates [mm], NaN where one is not known.")
      .def_property_readonly(
          "truth_px", [](const SeenHand& hand) { return landmarks_px(hand.truth.pose, hand.camera); },
          "(J, 2) landmarks in the image, column and row [px].")
      .def_property_readonly(
          "convention", [](const SeenHand& hand) { return std::string(hand.truth.pose.convention.name); },
          "The convention of its landmarks.")
      .def_property_readonly("occluders", &occluders_of,
                             "What lies before each landmark: none, own_hand, other_hand, person, object or "
                             "border (outside the image).")
      .def_property_readonly(
          "visible_share", [](const SeenHand& hand) { return hand.truth.visible_share; },
          "Part of its pixels that nothing else hides, [0, 1].")
      .def("__reduce__", &refuse_to_pickle)
      .def("__repr__", &text_of_hand);
}

void add_frame(py::module_& module) {
  add_true_hand(module);
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
      .def_property_readonly("labels", show(&Frame::labels),
                             "Truth: (rows, columns) uint8, 0 nothing, 1 the hand of truth_mm, 2 another "
                             "hand, 3 a person, 4 an object; None where not known.")
      .def_property_readonly(
          "camera", [](const Frame& frame) { return frame.camera; }, "The frame's Camera.")
      .def_property_readonly(
          "truth_mm", &truth_mm,
          "Truth: (J, 3) landmarks in camera coordinates [mm], NaN where one is not known; or None.")
      .def_property_readonly("truth_px", &truth_px,
                             "Truth: (J, 2) landmarks in the image, column and row [px]; or None.")
      .def_property_readonly("hands", &hands_of,
                             "Truth: a TrueHand for each hand in view, that of truth_mm first; empty: not "
                             "known, or none.")
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
