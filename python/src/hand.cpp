// SPDX-License-Identifier: Apache-2.0
#include "hand.h"

#include "arrays.h"
#include "bindings.h"
#include "checked_text.h"
#include "landmark_names.h"
#include "side_name.h"

#include <cmath>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <pybind11/numpy.h>

#include "knuckle/core/error.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc =
    R"(One hand of a frame. Arrays have a row per landmark, in the order of `landmark_names`.)";

py::str name_as_str(HandAngle angle) {
  return std::string(name_of(angle));
}

std::optional<HandAngle> angle_named(std::string_view name) {
  for (int i = 0; i < kHandAngleCount; ++i) {
    if (name_of(static_cast<HandAngle>(i)) == name) return static_cast<HandAngle>(i);
  }
  return std::nullopt;
}

/// Throws Python's TypeError where it is no number.
double real_from(const py::handle& value) {
  const double real = PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) throw py::error_already_set();
  return real;
}

/// All NaN where the method gives no confidences.
py::array_t<double> confidence_of(const HandRecord& hand) {
  py::array_t<double> confidence(std::ssize(hand.landmarks_mm));
  auto values = confidence.mutable_unchecked<1>();
  for (py::ssize_t i = 0; i < values.size(); ++i)
    values(i) = hand.confidence.empty() ? kNaN : hand.confidence[static_cast<std::size_t>(i)];
  return confidence;
}

py::object angles_of(const HandRecord& hand) {
  if (hand.angles_rad.empty()) return py::none();
  py::dict angles;
  for (const auto& [name, angle] : hand.angles_rad) angles[py::str(name)] = angle;
  return angles;
}

py::object skeleton_of_hand(const HandRecord& hand) {
  if (hand.skeleton.empty()) return py::none();
  return py::str(hand.skeleton);
}

py::object side_of(const HandRecord& hand) {
  if (!hand.side) return py::none();
  return py::str(side_name(*hand.side));
}

std::string text_of(const HandRecord& hand) {
  return fmt::format("<knuckle.Hand {}, {}, score {:.2f}>", hand.id,
                     hand.side ? side_name(*hand.side) : "of unknown side", hand.score);
}

}  // namespace

py::dict dict_of(const HandAngles& angles) {
  py::dict by_name;
  for (int i = 0; i < kHandAngleCount; ++i) {
    const auto angle = static_cast<HandAngle>(i);
    by_name[name_as_str(angle)] = angles[angle];
  }
  return by_name;
}

HandAngles angles_from(const py::dict& by_name) {
  HandAngles angles;
  for (const auto& [key, value] : by_name) {
    const std::string name = checked_text(py::str(key), "angles_rad");
    const auto angle = angle_named(name);
    if (!angle) fail("angles_rad: '{}' is no angle of a hand; HandSkeleton.limits_rad names them all", name);
    angles[*angle] = real_from(value);
    if (!std::isfinite(angles[*angle])) fail("angles_rad: {} is {}, expected a number", name, angles[*angle]);
  }
  return angles;
}

HandRecord record_of(const TrackedHand& hand, const Camera& camera) {
  HandRecord record = hand_record(hand.pose, Projection(camera), PixelOrigin::centre);
  record.id = hand.id;
  record.side = hand.side;
  record.score = hand.score;
  record.skeleton = hand.skeleton;
  for (int i = 0; i < kHandAngleCount; ++i) {
    const auto angle = static_cast<HandAngle>(i);
    record.angles_rad.emplace_back(name_of(angle), hand.angles[angle]);
  }
  return record;
}

void add_hand(py::module_& module) {
  py::class_<HandRecord>(module, "Hand", kDoc)
      .def_property_readonly(
          "landmarks_mm", [](const HandRecord& hand) { return array_of(hand.landmarks_mm); },
          "(J, 3) float64, x right, y down, z forward of the camera [mm]; NaN where a landmark is not known.")
      .def_property_readonly(
          "landmarks_px", [](const HandRecord& hand) { return array_of(hand.landmarks_px); },
          "(J, 2) float64, column and row [px]; the centre of the first pixel is (0, 0).")
      .def_property_readonly("confidence", &confidence_of,
                             "(J,) float64, [0, 1]; NaN where the method gives none.")
      .def_property_readonly("side", &side_of, "right or left; None where not known.")
      .def_readonly("score", &HandRecord::score, "How sure it is that this is a hand, [0, 1].")
      .def_readonly("id", &HandRecord::id, "Of a followed hand; otherwise its rank in the frame, from 1 on.")
      .def_property_readonly(
          "convention", [](const HandRecord& hand) { return std::string(hand.convention.name); },
          "Name of the landmarks' convention.")
      .def_property_readonly(
          "landmark_names", [](const HandRecord& hand) { return landmark_names(hand.convention); },
          "J names, in the order of the arrays.")
      .def_property_readonly("angles_rad", &angles_of,
                             "Joint angles by name [rad]; None where no hand model was fitted.")
      .def_property_readonly("skeleton", &skeleton_of_hand, "Name of the fitted hand model, or None.")
      .def("__reduce__", &refuse_to_pickle)
      .def("__repr__", &text_of);
}

}  // namespace knuckle::python
