// SPDX-License-Identifier: Apache-2.0
#include "knuckle/track/tracker.h"

#include "arrays.h"
#include "bindings.h"
#include "garbage_collected.h"
#include "hand.h"
#include "held_pipeline.h"

#include <memory>
#include <vector>

#include <pybind11/stl.h>

#include "knuckle/core/error.h"

namespace knuckle::python {
namespace py = pybind11;

namespace {

constexpr const char* kDoc =
    R"(Follows hands from frame to frame: ids, sides, a skeleton of constant bones, smoothing.

pipeline: a Pipeline; Pipeline.load(knuckle.data_file("pipelines/track.toml")) is made for this. Its table [tracker]
    says how hands are followed; without one the defaults do.

One thread at a time may call it. Where time goes back, stands still or leaps by more than a second, or
Frame.sequence changes, all hands are forgotten.)";

/// What Python's Tracker is: it keeps its pipeline's Python object.
struct HeldTracker {
  py::object pipeline;  ///< none: it was collected as garbage
  std::unique_ptr<Tracker> tracker;
};

py::object* pipeline_in(HeldTracker& held) {
  return &held.pipeline;
}

HeldTracker tracker_of(const HeldPipeline& held) {
  const TrackerOptions options = held.pipeline.tracker().value_or(TrackerOptions{});
  // The object that it is the value of, not a new one.
  return {py::cast(held, py::return_value_policy::reference),
          std::make_unique<Tracker>(held.pipeline, options)};
}

Tracker& tracker_in(HeldTracker& held) {
  if (!held.pipeline) fail("tracker: its pipeline is gone: the interpreter has collected it as garbage");
  return *held.tracker;
}

std::vector<HandRecord> update(HeldTracker& held, const Frame& frame) {
  Tracker& tracker = tracker_in(held);
  const WithoutLock unlocked;
  std::vector<HandRecord> hands;
  for (const TrackedHand& hand : tracker.update(frame)) hands.push_back(record_of(hand, frame.camera));
  return hands;
}

}  // namespace

void add_tracker(py::module_& module) {
  py::class_<HeldTracker>(module, "Tracker", garbage_collected<HeldTracker, pipeline_in>(), kDoc)
      .def(py::init(&tracker_of), py::arg("pipeline"))
      .def("update", &update, py::arg("frame"),
           "List of the Hands in the next Frame, in the order of their ids. Raises knuckle.Error where its "
           "time is not "
           "finite, or where another call has not ended: of a second thread, or of its own pipeline's "
           "estimator.")
      .def("__reduce__", &refuse_to_pickle)
      .def(
          "reset", [](HeldTracker& held) { tracker_in(held).reset(); }, "Begins anew, with id 1.");
}

}  // namespace knuckle::python
