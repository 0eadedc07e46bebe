// SPDX-License-Identifier: Apache-2.0
// The extension module knuckle._knuckle; knuckle/__init__.py shows it to users.
#include "bindings.h"

#include <cstddef>

namespace {

void* refuse_unmade(std::size_t /*size*/) {
  throw pybind11::type_error("an object that was never made: call its class, not only __new__");
}

/// `X.__new__(X)` makes an object without a C++ value. Where one is asked for it, pybind11 would take memory
/// with anything in it for the value, from the function that a class has for this: ours refuses.
void refuse_unmade_objects(const pybind11::module_& module) {
  for (const auto& [name, member] : pybind11::dict(module.attr("__dict__"))) {
    if (!pybind11::isinstance<pybind11::type>(member)) continue;
    auto* const made_by = pybind11::detail::get_type_info(reinterpret_cast<PyTypeObject*>(member.ptr()));
    if (made_by != nullptr) made_by->operator_new = refuse_unmade;
  }
}

}  // namespace

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
  refuse_unmade_objects(module);
}
