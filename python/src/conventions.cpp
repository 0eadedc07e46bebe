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
    by_name[pybind11::str(std::string(convention.name))] = landmark_names(convention);
  module.attr("conventions") = by_name;
}

}  // namespace knuckle::python
