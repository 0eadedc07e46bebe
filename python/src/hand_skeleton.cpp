// SPDX-License-Identifier: Apache-2.0
#include "knuckle/hand/hand_skeleton.h"

#include "arrays.h"
#include "bindings.h"
#include "hand.h"

#include <cmath>
#include <optional>
#include <string>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "knuckle/core/error.h"
#include "knuckle/hand/adult_skeleton.h"
#include "knuckle/hand/skeleton_fit.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc = R"(One person's right hand as a mechanism: poses the 22 landmarks by angles.

Its axes: the origin is the wrist, x points from the little finger's side to the thumb's, y from the wrist to the
middle finger's MCP, z out of the palm. All angles 0 are the straight hand.)";

constexpr const char* kLandmarksDoc =
    R"((22, 3) landmarks in camera coordinates [mm], in the order of knuckle22.

angles_rad: joint angles by name [rad]; one that is not given is 0.
camera_from_hand: (4, 4) rigid transform, shifts in mm; None: the hand's own axes.
size: factor on all lengths, above 0.)";

constexpr const char* kFitDoc = R"(Inverse kinematics: the pose whose landmarks lie nearest to these.

landmarks_mm: (22, 3) in camera coordinates [mm], in the order of knuckle22; NaN where one is not known.
weights: (22,), not negative; None: all 1.

Returns a SkeletonFit, or None where fewer than three landmarks are known.)";

py::array_t<double> landmarks_of(const HandSkeleton& skeleton, const SkeletonPose& pose) {
  return array_of(landmarks(skeleton, pose));
}

py::array_t<double> posed(const HandSkeleton& skeleton, const py::dict& angles_rad,
                          const py::object& camera_from_hand, double size) {
  if (!(size > 0.0 && std::isfinite(size))) fail("size: is {}, expected a number above 0", size);
  SkeletonPose pose{.angles = angles_from(angles_rad), .size = size};
  if (!camera_from_hand.is_none())
    pose.camera_from_hand = transform_from(camera_from_hand, "camera_from_hand");
  return landmarks_of(skeleton, pose);
}

LandmarkTargets targets_from(const py::object& landmarks_mm, const py::object& weights) {
  const auto points = doubles(landmarks_mm, {kSupersetSize, 3}, "landmarks_mm");
  LandmarkTargets targets;
  for (int i = 0; i < kSupersetSize; ++i)
    targets[static_cast<std::size_t>(i)].point = Point3(points.at(i, 0), points.at(i, 1), points.at(i, 2));
  if (weights.is_none()) return targets;
  const auto values = doubles(weights, {kSupersetSize}, "weights");
  for (int i = 0; i < kSupersetSize; ++i) targets[static_cast<std::size_t>(i)].weight = values.at(i);
  return targets;
}

/// What Python shows of a fit.
struct FittedSkeleton {
  HandSkeleton skeleton;
  SkeletonFit fit;
};

std::optional<FittedSkeleton> fitted(const HandSkeleton& skeleton, const py::object& landmarks_mm,
                                     const py::object& weights) {
  const LandmarkTargets targets = targets_from(landmarks_mm, weights);
  const WithoutLock unlocked;
  const std::optional<SkeletonFit> fit = fit_skeleton(skeleton, targets);
  if (!fit) return std::nullopt;
  return FittedSkeleton{skeleton, *fit};
}

py::dict limits_of(const HandSkeleton& skeleton) {
  py::dict limits;
  for (int i = 0; i < kHandAngleCount; ++i) {
    const auto angle = static_cast<HandAngle>(i);
    limits[py::str(std::string(name_of(angle)))] =
        py::make_tuple(skeleton.limits[angle].low, skeleton.limits[angle].high);
  }
  return limits;
}

void add_fit(py::module_& module) {
  py::class_<FittedSkeleton>(module, "SkeletonFit", "A skeleton fitted to landmarks.")
      .def("__reduce__", &refuse_to_pickle)
      .def_property_readonly(
          "angles_rad", [](const FittedSkeleton& fitted) { return dict_of(fitted.fit.pose.angles); },
          "Joint angles by name [rad], within the skeleton's limits.")
      .def_property_readonly(
          "camera_from_hand",
          [](const FittedSkeleton& fitted) { return matrix_of(fitted.fit.pose.camera_from_hand); },
          "(4, 4) rigid transform, shifts in mm.")
      .def_property_readonly(
          "size", [](const FittedSkeleton& fitted) { return fitted.fit.pose.size; }, "Factor on all lengths.")
      .def_property_readonly(
          "landmarks_mm",
          [](const FittedSkeleton& fitted) { return landmarks_of(fitted.skeleton, fitted.fit.pose); },
          "(22, 3) of the fitted skeleton, in camera coordinates [mm].")
      .def_property_readonly(
          "rms_mm", [](const FittedSkeleton& fitted) { return fitted.fit.rms_mm; },
          "Root mean square of the weighted distances to what it was fitted to [mm].");
}

}  // namespace

void add_hand_skeleton(py::module_& module) {
  add_fit(module);
  py::class_<HandSkeleton>(module, "HandSkeleton", kDoc)
      .def("__reduce__", &refuse_to_pickle)
      .def_static(
          "adult", [] { return adult_skeleton(); },
          "The right hand of a mean adult; 186 mm from wrist to middle tip.")
      .def_readonly("name", &HandSkeleton::name, "For people and files.")
      .def_property_readonly("limits_rad", &limits_of,
                             "Lowest and highest value of each angle, by its name [rad].")
      .def(
          "scaled",
          [](const HandSkeleton& skeleton, double factor) {
            if (!(factor > 0.0 && std::isfinite(factor)))
              fail("factor: is {}, expected a number above 0", factor);
            return scaled(skeleton, factor);
          },
          py::arg("factor"), "The hand with all lengths multiplied by factor, above 0.")
      .def(
          "mirrored", [](const HandSkeleton& skeleton) { return mirrored(skeleton); },
          "The same hand of the other side: reflected in x.")
      .def("landmarks", &posed, py::arg("angles_rad") = py::dict(), py::arg("camera_from_hand") = py::none(),
           py::arg("size") = 1.0, kLandmarksDoc)
      .def("fit", &fitted, py::arg("landmarks_mm"), py::arg("weights") = py::none(), kFitDoc);
}

}  // namespace knuckle::python
