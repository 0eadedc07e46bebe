// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/tracker.h"

#include "arrays.h"
#include "bindings.h"
#include "hand.h"

#include <vector>

#include <pybind11/stl.h>

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc =
    R"(Follows hands from frame to frame: ids, sides, a skeleton of constant bones, smoothing.

pipeline: a Pipeline; Pipeline.load(knuckle.data_file("pipelines/track.toml")) is made for this. Its table [tracker]
    says how hands are followed; without one the defaults do.

One thread at a time may call it. Where time goes back, stands still or leaps by more than a second, or
Frame.sequence changes, all hands are forgotten.)";

/// A tracker that keeps its pipeline's Python object.
std::unique_ptr<Tracker> tracker_of(const Pipeline& pipeline) {
  return std::make_unique<Tracker>(pipeline, pipeline.tracker().value_or(TrackerOptions{}));
}

std::vector<HandRecord> update(Tracker& tracker, const Frame& frame) {
  const WithoutLock unlocked;
  std::vector<HandRecord> hands;
  for (const TrackedHand& hand : tracker.update(frame)) hands.push_back(record_of(hand, frame.camera));
  return hands;
}

}  // namespace

void add_tracker(py::module_& module) {
  py::class_<Tracker>(module, "Tracker", kDoc)
      .def(py::init(&tracker_of), py::arg("pipeline"), py::keep_alive<1, 2>())
      .def("update", &update, py::arg("frame"),
           "List of the Hands in the next Frame, in the order of their ids. Raises knuckle.Error where its "
           "time is not "
           "finite, or two threads call at once.")
      .def("__reduce__", &refuse_to_pickle)
      .def("reset", &Tracker::reset, "Begins anew, with id 1.");
}

}  // namespace knuckle::python
