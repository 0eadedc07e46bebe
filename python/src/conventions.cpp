// SPDX-License-Identifier: Apache-2.0
#include "bindings.h"
#include "landmark_names.h"

#include "knuckle/core/landmarks.h"

namespace knuckle::python {

pybind11::list landmark_names(const Convention& convention) {
  pybind11::list names;
  for (const Landmark landmark : convention.landmarks) names.append(name_of(landmark));
  return names;
}

void add_conventions(pybind11::module_& module) {
  pybind11::dict by_name;
  for (const Convention& convention : conventions())
    by_name[pybind11::str(std::string(convention.name))] = pybind11::tuple(landmark_names(convention));
  // Read-only: what the library knows does not change with it.
  module.attr("conventions") = pybind11::reinterpret_steal<pybind11::object>(PyDictProxy_New(by_name.ptr()));
}

}  // namespace knuckle::python
