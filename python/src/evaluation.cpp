// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/evaluation.h"

#include "bindings.h"
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
  if (names_a_source(text)) {
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

/// The poses of an array (frames, J, 3) of u, v [px] and depth [mm].
PoseSequence poses_from(const py::array_t<double>& array, const std::string& name,
                        const Convention& convention) {
  if (array.ndim() != 3 || array.shape(1) != convention.size() || array.shape(2) != 3) {
    fail(
        "predictions '{}': expected an array (frames, {}, 3) of u, v [px] and depth [mm], in the landmarks "
        "of {}",
        name, convention.size(), convention.name);
  }
  const auto values = array.unchecked<3>();
  PoseSequence poses{"predictions '" + name + "'", convention, {}};
  for (py::ssize_t frame = 0; frame < values.shape(0); ++frame) {
    HandPose pose = HandPose::missing(convention);
    for (py::ssize_t i = 0; i < values.shape(1); ++i) {
      const ImagePoint point{values(frame, i, 0), values(frame, i, 1), values(frame, i, 2)};
      if (!point.is_missing()) pose.joints[static_cast<std::size_t>(i)] = point;
    }
    poses.poses.push_back(std::move(pose));
  }
  return poses;
}

/// Predictions as they are given: arrays, read at once, and files, read without the interpreter's lock.
struct GivenPredictions {
  std::vector<Predictions> methods;  ///< in the order given; those of files are empty
  std::vector<std::pair<std::size_t, NamedPath>> files;

  GivenPredictions(const py::dict& given, const std::optional<Convention>& convention) {
    for (const auto& [key, value] : given) {
      const std::string name = py::str(key);
      methods.push_back({name, {"", superset_convention(), {}}});
      if (py::isinstance<py::array>(value)) {
        const auto array = py::array_t<double>::ensure(value);
        if (!array) throw py::type_error("predictions '" + name + "': expected an array of numbers");
        methods.back().sequence = poses_from(array, name, convention.value_or(superset_convention()));
      } else {
        files.push_back({methods.size() - 1, {name, path_from(value)}});
      }
    }
  }

  void read_files(const std::optional<Convention>& convention, const OpenedTruth& opened) {
    for (const auto& [place, file] : files) {
      const PoseNumbers numbers = read_pose_numbers(file.path, convention);
      methods[place].sequence = poses_from(numbers, opened.truth.projections, opened.origin);
    }
  }
};

std::string evaluate_as_json(const std::string& truth_text, const py::dict& predictions,
                             const std::optional<std::string>& convention_name,
                             const std::optional<Camera>& camera,
                             const std::map<std::string, std::filesystem::path>& boxes,
                             const std::optional<std::filesystem::path>& landmarks, bool common) {
  std::optional<Convention> convention;
  if (convention_name) convention = convention_from_option(*convention_name);
  GivenPredictions given(predictions, convention);
  if (given.methods.empty() && boxes.empty()) fail("evaluate: nothing to score: give predictions or boxes");
  return interruptible([&] {
    OpenedTruth opened = truth_from(truth_text, convention, camera);
    given.read_files(convention, opened);
    if (landmarks) move_landmarks(LandmarkDefinition::load(*landmarks), opened.truth, given.methods);
    std::optional<Evaluation> evaluation;
    if (!given.methods.empty()) evaluation = evaluate(opened.truth, given.methods, common);
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
             py::arg("common"));
}

}  // namespace knuckle::python
