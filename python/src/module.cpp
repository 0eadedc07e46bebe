// SPDX-License-Identifier: Apache-2.0
// The extension module knuckle._knuckle; knuckle/__init__.py shows it to users.
#include "bindings.h"

PYBIND11_MODULE(_knuckle, module) {
  using namespace knuckle::python;
  module.doc() = "Hand pose from depth images: what of the package `knuckle` is written in C++.";
  module.attr("__version__") = KNUCKLE_VERSION;
  watch_for_the_interpreters_end();
  add_errors(module);
  add_conventions(module);
  add_camera(module);
  add_frame(module);
  add_source(module);
  add_stream(module);
  add_hand(module);
  add_estimator(module);
  add_pipeline(module);
  add_tracker(module);
  add_hand_skeleton(module);
  add_evaluation(module);
}
