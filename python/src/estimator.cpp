// SPDX-License-Identifier: Apache-2.0
#include "estimator.h"

#include "arrays.h"
#include "bindings.h"
#include "checked_text.h"
#include "garbage_collected.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "knuckle/camera/projection.h"
#include "knuckle/core/error.h"
#include "knuckle/core/frame.h"
#include "knuckle/core/own_convention.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc = R"(An estimator of one's own: a function from a patch to landmarks.

estimate: called with a patch, (size_px, size_px) of float32, a copy. It returns landmarks, anything that numpy makes
    an array (J, 3) of: u and v from -1 (centre of the patch's first column, row) to 1 (of the last), and the depth d
    in the unit of the patch's values; or a pair of landmarks and confidence, (J,) from 0 to 1. Hands are right ones:
    left ones are shown in a mirror. It is called from the thread that estimates, with the interpreter's lock held.
    What it raises ends the estimate and is raised there. A landmark that is not finite, further than 1000 from the
    middle of the patch or behind the camera is a knuckle.Error.
convention: name of the J landmarks, or the file (.toml) of one of your own.
patch: "cube": what lies in a cube around the hand, -1 at its near end, 1 at its far end and where nothing is
    measured. "hand": the segmented hand alone, in standard deviations from its mean depth, 3 where there is no hand.
size_px: width and height of the patch, 2 to 1024.
cube_mm: side of the cube, 10 to 2000 [mm].
passes: how often each hand is looked at, 1 to 5 (only cubes more than once), each time but the first around the mean
    of the landmarks that were found.
sure_confidence: mean confidence, 0 to 1, from which on it may be a hand; 0: the confidence does not tell.

Pipeline.default, .load and .from_toml take it as `estimator`, in place of the tables [estimator] and
[patch]. Raises knuckle.Error
where a value is out of range.)";

/// Of a landmark from the middle of its patch, in patch coordinates. A network that has learned nothing yet
/// may be far off; beyond this the function means something else, as pixels or millimetres.
constexpr double kFurthest = 1000.0;

/// Asks the function. It belongs to Python, and may be called and left with the interpreter's lock alone.
class FunctionEstimator final : public Estimator {
 public:
  explicit FunctionEstimator(OwnEstimator own) : own_(std::move(own)), patches_(own_.patch) {}
  ~FunctionEstimator() override {
    const WithLock locked;
    PyObject* const function = own_.function.release().ptr();
    in_python([&] { Py_XDECREF(function); });
  }
  FunctionEstimator(const FunctionEstimator&) = delete;
  FunctionEstimator& operator=(const FunctionEstimator&) = delete;

  Convention convention() const override { return own_.convention; }
  const PatchExtractor& patches() const override { return patches_; }
  int passes() const override { return own_.passes; }
  double sure_confidence() const override { return own_.sure_confidence; }
  py::object& function() { return own_.function; }

  PatchPose estimate(const HandPatch& patch) const override {
    const WithLock locked;
    return in_python([&] { return pose_in(answer_to(patch), patch); });
  }

 private:
  PatchPose pose_in(const py::object& answer, const HandPatch& patch) const {
    PatchPose pose;
    if (!py::isinstance<py::tuple>(answer)) {
      pose.joints = joints_in(answer, patch);
      return pose;
    }
    const auto pair = py::reinterpret_borrow<py::tuple>(answer);
    if (pair.size() != 2) {
      fail("the estimator gave a tuple of {}, expected landmarks, or a pair of landmarks and confidence",
           pair.size());
    }
    pose.joints = joints_in(pair[0], patch);
    pose.confidence = confidence_in(pair[1]);
    return pose;
  }

  py::object answer_to(const HandPatch& patch) const {
    if (!own_.function) fail("the estimator's function is gone: the interpreter has collected it as garbage");
    const py::array_t<float> pixels({patch.pixels.height(), patch.pixels.width()}, patch.pixels.data());
    const auto answer = py::reinterpret_steal<py::object>(
        in_python([&] { return PyObject_CallOneArg(own_.function.ptr(), pixels.ptr()); }));
    if (!answer) throw py::error_already_set();
    return answer;
  }

  std::vector<PatchPoint> joints_in(const py::object& landmarks, const HandPatch& patch) const {
    const Projection projection(patch.camera);
    const auto numbers = doubles(landmarks, {own_.convention.size(), 3}, "the estimator's landmarks");
    const auto values = numbers.unchecked<2>();
    std::vector<PatchPoint> joints;
    for (py::ssize_t i = 0; i < values.shape(0); ++i) {
      const PatchPoint& joint = joints.emplace_back(PatchPoint{values(i, 0), values(i, 1), values(i, 2)});
      check_joint(joint, projection.to_camera(patch.geometry.to_image(joint)), i);
    }
    return joints;
  }

  /// A landmark in the patch, and the place before the camera that it stands for.
  void check_joint(const PatchPoint& joint, const Point3& place, py::ssize_t i) const {
    const std::string_view name = name_of(own_.convention.landmarks[i]);
    const double furthest = std::max({std::abs(joint.u), std::abs(joint.v), std::abs(joint.d)});
    if (!std::isfinite(joint.u + joint.v + joint.d))
      fail("the estimator's landmarks: {} is not finite", name);
    if (furthest > kFurthest) {
      fail(
          "the estimator's landmarks: {} has the value {:g}, expected -1 to 1 within the patch, and at most "
          "{:g}",
          name, furthest, kFurthest);
    }
    if (!place.allFinite() || !(place.z() > 0.0))
      fail("the estimator's landmarks: {} lies behind the camera", name);
  }

  std::vector<float> confidence_in(const py::object& given) const {
    const auto numbers = doubles(given, {own_.convention.size()}, "the estimator's confidence");
    std::vector<float> confidence;
    for (py::ssize_t i = 0; i < numbers.size(); ++i) {
      const double value = numbers.at(i);
      if (!(value >= 0.0 && value <= 1.0)) {
        fail("the estimator's confidence: that of {} is {}, expected 0 to 1",
             name_of(own_.convention.landmarks[i]), value);
      }
      confidence.push_back(static_cast<float>(value));
    }
    return confidence;
  }

  OwnEstimator own_;
  PatchExtractor patches_;
};

/// The options that a pipeline file would hold, under the same names and in the same ranges.
struct LookOptions {
  int passes;
  double sure_confidence;

  void visit(OptionVisitor& visitor) {
    visitor.integer("passes", passes, closed(1, 5));
    visitor.real("sure_confidence", sure_confidence, closed(0, 1));
  }
};

OwnEstimator own_estimator(const py::object& function, const std::string& convention,
                           const std::string& patch, int size_px, double cube_mm, int passes,
                           double sure_confidence) {
  if (PyCallable_Check(function.ptr()) == 0) throw py::type_error("estimate: expected something to call");
  LookOptions looks{passes, sure_confidence};
  check_options(looks, "estimator");
  PatchOptions options{.size_px = size_px, .mode = checked_text(patch, "patch"), .cube_mm = cube_mm};
  check_options(options, "estimator");
  if (!options.is_cube() && passes != 1)
    fail("estimator: passes is {}, but a patch of the hand is looked at once", passes);
  return {function, convention_from_option(checked_text(convention, "convention")), options, passes,
          sure_confidence};
}

constexpr const char* kCropDoc =
    R"(The Patch of a hand in a Frame, as the pipeline shows it to the function: for training.

centre_mm: (x, y, z) in camera coordinates, in the middle of the hand. None where nothing is measured around it. Raises
knuckle.Error for patches of the kind "hand", which segmentation cuts out.)";

std::optional<HandPatch> crop(const OwnEstimator& own, const Frame& frame, const py::object& centre_mm) {
  const auto values = doubles(centre_mm, {3}, "centre_mm");
  const Point3 centre(values.at(0), values.at(1), values.at(2));
  if (!own.patch.is_cube())
    fail("estimator: only cubes are cut out around a point, this one wants the hand alone");
  const WithoutLock unlocked;
  const ImagePoint place = Projection(frame.camera).to_image(centre);
  return PatchExtractor(own.patch).extract_around(frame, place);
}

using Points = py::array_t<double>;

/// (N, 3), as many as there are.
Points points_from(const py::object& values, std::string_view what) {
  const Points array = real_numbers(values, what, "points, an array of the shape (N, 3)");
  return doubles(array, {array.ndim() == 2 ? array.shape(0) : 0, 3}, what);
}

Points patch_coordinates(const HandPatch& patch, const py::object& landmarks_mm) {
  const Points given = points_from(landmarks_mm, "landmarks_mm");
  const Projection projection(patch.camera);
  Points result({given.shape(0), py::ssize_t{3}});
  for (py::ssize_t i = 0; i < given.shape(0); ++i) {
    const Point3 point(given.at(i, 0), given.at(i, 1), given.at(i, 2));
    const PatchPoint place = patch.geometry.to_patch(projection.to_image(point));
    result.mutable_at(i, 0) = place.u;
    result.mutable_at(i, 1) = place.v;
    result.mutable_at(i, 2) = place.d;
  }
  return result;
}

Points camera_coordinates(const HandPatch& patch, const py::object& landmarks) {
  const Points given = points_from(landmarks, "landmarks");
  const Projection projection(patch.camera);
  std::vector<Point3> points;
  for (py::ssize_t i = 0; i < given.shape(0); ++i) {
    const PatchPoint place{given.at(i, 0), given.at(i, 1), given.at(i, 2)};
    points.push_back(projection.to_camera(patch.geometry.to_image(place)));
  }
  return array_of(points);
}

py::object* function_in(OwnEstimator& own) {
  return &own.function;
}

void add_patch(py::module_& module) {
  py::class_<HandPatch>(module, "Patch", "A hand cut out of a frame: what an Estimator's function is shown.")
      .def_property_readonly(
          "pixels",
          [](const py::object& self) { return view_of(self.cast<const HandPatch&>().pixels, self); },
          "(size_px, size_px) of float32: the patch's own memory.")
      .def("to_patch", &patch_coordinates, py::arg("landmarks_mm"),
           "Where points in camera coordinates, (N, 3) [mm], lie in the patch: (N, 3) of u, v and d.")
      .def("to_camera", &camera_coordinates, py::arg("landmarks"),
           "Where points in the patch's coordinates, (N, 3) of u, v and d, lie before the camera: (N, 3) "
           "[mm].")
      .def("__reduce__", &refuse_to_pickle);
}

}  // namespace

AskedEstimator estimator_of(const std::optional<OwnEstimator>& own) {
  if (!own) return {};
  auto estimator = std::make_unique<FunctionEstimator>(*own);
  py::object& function = estimator->function();
  return {std::move(estimator), &function};
}

void add_estimator(py::module_& module) {
  add_patch(module);
  py::class_<OwnEstimator>(module, "Estimator", garbage_collected<OwnEstimator, function_in>(), kDoc)
      .def(py::init(&own_estimator), py::arg("estimate"), py::arg("convention"), py::kw_only(),
           py::arg("patch") = "cube", py::arg("size_px") = 128, py::arg("cube_mm") = 250.0,
           py::arg("passes") = 1, py::arg("sure_confidence") = 0.0)
      .def_property_readonly(
          "convention", [](const OwnEstimator& own) { return std::string(own.convention.name); },
          "Name of the convention of its landmarks.")
      .def("crop", &crop, py::arg("frame"), py::arg("centre_mm"), kCropDoc)
      .def("__reduce__", &refuse_to_pickle)
      .def("__repr__", [](const OwnEstimator& own) {
        return fmt::format("<knuckle.Estimator, {}>", own.convention.name);
      });
}

}  // namespace knuckle::python
