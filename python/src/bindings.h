// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "interpreter_lock.h"

#include <string>

#include <pybind11/pybind11.h>

namespace knuckle::python {

// Each adds its part of the package to the module, in this order: signatures in docstrings name types that
// were added before.
void add_errors(pybind11::module_& module);
void add_conventions(pybind11::module_& module);
void add_camera(pybind11::module_& module);
void add_frame(pybind11::module_& module);
void add_source(pybind11::module_& module);
void add_stream(pybind11::module_& module);
void add_hand(pybind11::module_& module);
void add_estimator(pybind11::module_& module);
void add_pipeline(pybind11::module_& module);
void add_tracker(pybind11::module_& module);
void add_hand_skeleton(pybind11::module_& module);
void add_evaluation(pybind11::module_& module);

/// What a class that is no value gets as its `__reduce__`. Without one, the old protocols of pickle make an
/// instance that has no C++ object, and pybind11 ends the interpreter when that is freed.
inline pybind11::object refuse_to_pickle(const pybind11::object& self) {
  throw pybind11::type_error(
      "cannot pickle " + std::string(pybind11::str(pybind11::type::of(self).attr("__name__"))) + " objects");
}

}  // namespace knuckle::python
