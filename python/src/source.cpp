// SPDX-License-Identifier: Apache-2.0
#include "bindings.h"
#include "checked_text.h"

#include <filesystem>
#include <memory>
#include <string>

#include <pybind11/stl/filesystem.h>

#include "knuckle/data/frame_source.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

std::shared_ptr<FrameSource> open(const std::string& text) {
  const WithoutLock unlocked;
  return open_source(checked_text(text, "source"));
}

std::shared_ptr<FrameSource> open_manifest(const std::filesystem::path& path) {
  const WithoutLock unlocked;
  return open_synthetic(path);
}

Frame read(const FrameSource& source, std::int64_t index) {
  if (index < 0 || index >= source.size()) throw py::index_error("frame " + std::to_string(index));
  const WithoutLock unlocked;
  return source.read(index);
}

py::object convention_of(const FrameSource& source) {
  const auto convention = source.convention();
  if (!convention) return py::none();
  return py::str(std::string(convention->name));
}

}  // namespace

// What knuckle/_source.py makes a Python sequence of.
void add_source(py::module_& module) {
  py::class_<FrameSource, std::shared_ptr<FrameSource>>(module, "FrameSource")
      .def("read", &read, py::arg("index"))
      .def("__reduce__", &refuse_to_pickle)
      .def("__len__", &FrameSource::size)
      .def_property_readonly("convention", &convention_of);
  module.def("open_source", &open, py::arg("text"));
  module.def("open_manifest", &open_manifest, py::arg("path"));
}

}  // namespace knuckle::python
