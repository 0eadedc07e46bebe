// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/evaluation.h"

#include "arrays.h"
#include "bindings.h"
#include "checked_text.h"
#include "interruptible.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/data/boxes_file.h"
#include "knuckle/data/pose_coordinates.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/eval/metrics/score_files.h"
#include "knuckle/prepare/open_source.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

struct OpenedTruth {
  Truth truth;
  PixelOrigin origin = PixelOrigin::centre;  ///< of poses files that belong to it
};

OpenedTruth truth_from(const std::string& text, const std::optional<Convention>& convention,
                       const std::optional<Camera>& camera) {
  if (names_a_source(checked_text(text, "truth"))) {
    const auto source = open_source(text);
    return {truth_from_source(*source, text), source->pixel_origin()};
  }
  if (!camera) fail("{}: truth from a file needs its camera: camera=knuckle.Camera(...)", text);
  return {truth_from_file(text, convention, *camera)};
}

/// Throws Python's TypeError where it is no path.
std::filesystem::path path_from(const py::handle& value) {
  const auto path = py::reinterpret_steal<py::object>(PyOS_FSPath(value.ptr()));
  if (!path) throw py::error_already_set();
  return path.cast<std::filesystem::path>();
}

/// The numbers of an array (frames, J, 3).
PoseNumbers numbers_from(const py::array_t<double>& array, const std::string& name,
                         const Convention& convention, const PoseCoordinates& coordinates) {
  if (array.ndim() != 3 || array.shape(1) != convention.size() || array.shape(2) != 3) {
    fail("predictions '{}': expected an array (frames, {}, 3) of {}, in the landmarks of {}", name,
         convention.size(),
         coordinates.kind == PoseCoordinates::Kind::xyz ? "x, y, z" : "u, v [px] and depth [mm]",
         convention.name);
  }
  const auto values = array.unchecked<3>();
  PoseNumbers numbers{"predictions '" + name + "'", convention, coordinates, {}};
  numbers.values.reserve(static_cast<std::size_t>(array.size()));
  for (py::ssize_t frame = 0; frame < values.shape(0); ++frame) {
    for (py::ssize_t i = 0; i < values.shape(1); ++i) {
      for (py::ssize_t k = 0; k < 3; ++k) numbers.values.push_back(values(frame, i, k));
    }
  }
  return numbers;
}

/// Predictions as they are given: arrays, copied at once, and files, read without the interpreter's lock.
class GivenPredictions {
 public:
  GivenPredictions(const py::dict& given, const std::optional<Convention>& convention,
                   const PoseCoordinates& coordinates)
      : convention_(convention), coordinates_(coordinates) {
    for (const auto& [key, value] : given) {
      const std::string name = checked_text(py::str(key), "predictions");
      if (py::isinstance<py::array>(value)) {
        const auto array = real_numbers(py::reinterpret_borrow<py::object>(value),
                                        "predictions '" + name + "'", "an array of numbers");
        given_.push_back(
            {name, {}, numbers_from(array, name, convention.value_or(superset_convention()), coordinates)});
      } else {
        given_.push_back({name, path_from(value), std::nullopt});
      }
    }
  }

  bool empty() const { return given_.empty(); }

  /// In the order given. u and v of arrays count from pixel centres, those of files as in the source's.
  std::vector<Predictions> read(const OpenedTruth& opened) const {
    std::vector<Predictions> methods;
    for (const Given& given : given_) {
      const PoseNumbers numbers =
          given.array ? *given.array : read_pose_numbers(given.file, convention_, coordinates_);
      methods.push_back({given.name, poses_from(numbers, opened.truth.projections,
                                                given.array ? PixelOrigin::centre : opened.origin)});
    }
    return methods;
  }

 private:
  struct Given {
    std::string name;
    std::filesystem::path file;
    std::optional<PoseNumbers> array;  ///< nothing: it is a file
  };

  std::optional<Convention> convention_;
  PoseCoordinates coordinates_;
  std::vector<Given> given_;
};

/// What numbers are, as format, axes and unit say.
PoseCoordinates coordinates_from(const std::string& format, const std::string& axes,
                                 const std::string& unit) {
  PoseCoordinates coordinates{coordinate_kind_from_text(checked_text(format, "format")),
                              axes_from_text(checked_text(axes, "axes")),
                              unit_from_text(checked_text(unit, "unit"))};
  if (coordinates.kind == PoseCoordinates::Kind::uvd && coordinates.axes != PoseCoordinates().axes)
    fail("axes: tells of x y z; give format=\"xyz\" too");
  return coordinates;
}

std::string evaluate_as_json(const std::string& truth_text, const py::dict& predictions,
                             const std::optional<std::string>& convention_name,
                             const std::optional<Camera>& camera,
                             const std::map<std::string, std::filesystem::path>& boxes,
                             const std::optional<std::filesystem::path>& landmarks, bool common,
                             const std::string& format, const std::string& axes, const std::string& unit) {
  std::optional<Convention> convention;
  if (convention_name) convention = convention_from_option(checked_text(*convention_name, "convention"));
  const GivenPredictions given(predictions, convention, coordinates_from(format, axes, unit));
  if (given.empty() && boxes.empty()) fail("evaluate: nothing to score: give predictions or boxes");
  return interruptible([&] {
    OpenedTruth opened = truth_from(truth_text, convention, camera);
    std::vector<Predictions> methods = given.read(opened);
    if (landmarks) move_landmarks(LandmarkDefinition::load(*landmarks), opened.truth, methods);
    std::optional<Evaluation> evaluation;
    if (!methods.empty()) evaluation = evaluate(opened.truth, methods, common);
    std::vector<SegmentationScore> overlaps;
    for (const auto& [name, path] : boxes)
      overlaps.push_back(score_boxes(name, read_boxes_file(path), opened.truth.sequence.poses));
    return to_json(evaluation, overlaps);
  });
}

}  // namespace

// What knuckle/__init__.py makes a dict of.
void add_evaluation(py::module_& module) {
  module.def("evaluate_as_json", &evaluate_as_json, py::arg("truth"), py::arg("predictions"),
             py::arg("convention"), py::arg("camera"), py::arg("boxes"), py::arg("landmarks"),
             py::arg("common"), py::arg("format"), py::arg("axes"), py::arg("unit"));
}

}  // namespace knuckle::python
