// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/pipeline.h"

#include "arrays.h"
#include "bindings.h"
#include "checked_text.h"
#include "depth_array.h"
#include "estimator.h"
#include "garbage_collected.h"
#include "held_pipeline.h"
#include "landmark_names.h"

#include <filesystem>
#include <optional>
#include <string>

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "knuckle/core/resources.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/pipeline/record_of.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc = R"(Finds hands in depth images: segments, crops, estimates, refines.

Made by Pipeline.default(), Pipeline.load(path) or Pipeline.from_toml(text). It does not change, and may be used
by many threads at once. With the path of a landmark definition (`knuckle landmarks`) as `landmarks`, poses have its
landmarks in place of the model's. An Estimator of your own as `estimator` takes the place of the tables
[estimator] and [patch].)";

constexpr const char* kFromTomlDoc = R"(The pipeline that the text of a pipeline file describes.

folder: where relative paths in it start from; None: from that of the pipelines that come with Knuckle.)";

constexpr const char* kEstimateDoc = R"(The hands in one depth image.

depth: (rows, columns) array of float32, float64 or uint16. Times depth_unit_mm it is the distance along z [mm];
    what is NaN, infinite, not above 0 or masked (numpy.ma) is not measured. Any strides and byte order; it is read
    once, and never written.
camera: the Camera that took it, of the same size.
start: (x, y, z) in camera coordinates [mm] near the hand, which is then returned whatever its score; None: the
    whole image is searched, and what is not sure is not found.
depth_unit_mm: millimetres per count of the array.

Returns an Estimate. Raises TypeError where depth is no such array; knuckle.Error where sizes differ or a number is
impossible. Other Python threads run meanwhile.)";

/// What was found in one image; frame, name and time are told when it is written.
struct Estimate {
  FrameRecord record;
};

using Path = std::filesystem::path;

Pipeline with_landmarks(Pipeline pipeline, const std::optional<Path>& definition) {
  if (definition) pipeline.use_landmarks(LandmarkDefinition::load(*definition));
  return pipeline;
}

HeldPipeline load(const Path& path, const std::optional<Path>& landmarks,
                  const std::optional<OwnEstimator>& own) {
  auto [estimator, function] = estimator_of(own);
  const WithoutLock unlocked;
  return {with_landmarks(Pipeline::load(path, std::move(estimator)), landmarks), function};
}

HeldPipeline load_default(const std::optional<Path>& landmarks, const std::optional<OwnEstimator>& own) {
  return load(resource_path("pipelines/default.toml"), landmarks, own);
}

HeldPipeline from_toml(const std::string& text, const std::optional<Path>& folder,
                       const std::optional<Path>& landmarks, const std::optional<OwnEstimator>& own) {
  auto [estimator, function] = estimator_of(own);
  const WithoutLock unlocked;
  Pipeline pipeline =
      Pipeline::from_toml(text, folder ? *folder : resource_path("pipelines"), std::move(estimator));
  return {with_landmarks(std::move(pipeline), landmarks), function};
}

std::optional<Point3> start_from(const py::object& start) {
  if (start.is_none()) return std::nullopt;
  const auto values = doubles(start, {3}, "start");
  return Point3(values.at(0), values.at(1), values.at(2));
}

Estimate estimate(const HeldPipeline& held, const py::object& depth, const Camera& camera,
                  const py::object& start, double depth_unit_mm) {
  Frame frame;
  frame.depth_mm = depth_image(depth, camera, depth_unit_mm);
  frame.camera = camera;
  const Pipeline& pipeline = held.pipeline;
  const Search search{.start = start_from(start), .max_hands = pipeline.hand().max_hands};
  const WithoutLock unlocked;
  FrameResult result;
  result.camera = camera;
  result.estimate = pipeline.estimate(frame, search);
  return {record_of(result, PixelOrigin::centre)};
}

py::object* function_in(HeldPipeline& held) {
  return held.function;
}

std::string line_of(const Estimate& estimate, std::int64_t frame, std::string name,
                    std::optional<double> time_s) {
  FrameRecord record = estimate.record;
  record.frame = frame;
  record.name = std::move(name);
  record.time_s = time_s;
  return to_json_line(record);
}

std::string text_of(const Estimate& estimate) {
  return fmt::format("<knuckle.Estimate, {} hands, status '{}'>", estimate.record.hands.size(),
                     estimate.record.status);
}

void add_estimate(py::module_& module) {
  py::class_<Estimate>(module, "Estimate",
                       "What a pipeline sees in one image. No hand is an answer, not an error.")
      .def_property_readonly(
          "hands", [](const Estimate& estimate) { return estimate.record.hands; },
          "List of Hand, the surest first.")
      .def_property_readonly(
          "status", [](const Estimate& estimate) { return estimate.record.status; },
          "Empty where a sure hand was found; why there is none; or 'unsure', at a start.")
      .def("to_json", &line_of, py::arg("frame") = 0, py::arg("name") = "", py::arg("time_s") = py::none(),
           "The frame record as one line of JSON, as `knuckle estimate --records` writes it.")
      .def("__reduce__", &refuse_to_pickle)
      .def("__repr__", &text_of);
}

}  // namespace

void add_pipeline(py::module_& module) {
  add_estimate(module);
  py::class_<HeldPipeline>(module, "Pipeline", garbage_collected<HeldPipeline, function_in>(), kDoc)
      .def_static("default", &load_default, py::arg("landmarks") = py::none(),
                  py::arg("estimator") = py::none(),
                  "The pipeline for single frames that comes with Knuckle.")
      .def_static("load", &load, py::arg("path"), py::arg("landmarks") = py::none(),
                  py::arg("estimator") = py::none(), "The pipeline that a file describes.")
      .def_static("from_toml", &from_toml, py::arg("text"), py::arg("folder") = py::none(),
                  py::arg("landmarks") = py::none(), py::arg("estimator") = py::none(), kFromTomlDoc)
      .def("estimate", &estimate, py::arg("depth"), py::arg("camera"), py::arg("start") = py::none(),
           py::kw_only(), py::arg("depth_unit_mm") = 1.0, kEstimateDoc)
      .def_property_readonly(
          "convention", [](const HeldPipeline& held) { return std::string(held.pipeline.convention().name); },
          "Name of the convention of all poses.")
      .def_property_readonly(
          "landmark_names",
          [](const HeldPipeline& held) { return landmark_names(held.pipeline.convention()); },
          "J names, in the order of the arrays of its hands.")
      .def_property_readonly(
          "toml", [](const HeldPipeline& held) { return held.pipeline.resolved_options(); },
          "The pipeline file with all defaults filled in.")
      .def("__reduce__", &refuse_to_pickle)
      .def("__repr__", [](const HeldPipeline& held) {
        return fmt::format("<knuckle.Pipeline, {}>", held.pipeline.convention().name);
      });
  module.def(
      "data_file", [](const std::string& name) { return resource_path(checked_text(name, "name")); },
      py::arg("name"),
      "Path of a file that comes with Knuckle, for example \"pipelines/track.toml\" or "
      "\"manifests/demo.toml\".");
}

}  // namespace knuckle::python
