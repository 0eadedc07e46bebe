// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <utility>

#include <pybind11/pybind11.h>

namespace knuckle::python {

/// The C++ value of an object; null while it has none.
template <class T>
T* value_in(PyObject* self) {
  auto* const instance = reinterpret_cast<pybind11::detail::instance*>(self);
  // Python may look before pybind11 has made room for a value.
  if (!instance->simple_layout && instance->nonsimple.values_and_holders == nullptr) return nullptr;
  return static_cast<T*>(instance->get_value_and_holder().value_ptr());
}

/// Makes a class take part in Python's garbage collection: for one whose values hold a Python object, which
/// may hold the value's own object in turn. `object_in` says where a value T has it (null: nowhere). Values
/// have to get on without it: whoever is collected lets it go first.
template <class T, pybind11::object* (*object_in)(T&)>
pybind11::custom_type_setup garbage_collected() {
  return pybind11::custom_type_setup([](PyHeapTypeObject* class_object) {
    PyTypeObject& type = class_object->ht_type;
    type.tp_flags |= Py_TPFLAGS_HAVE_GC;
    type.tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
      Py_VISIT(Py_TYPE(self));
      T* const value = value_in<T>(self);
      const pybind11::object* const held = value != nullptr ? object_in(*value) : nullptr;
      if (held != nullptr) Py_VISIT(held->ptr());
      return 0;
    };
    type.tp_clear = [](PyObject* self) {
      T* const value = value_in<T>(self);
      pybind11::object* const held = value != nullptr ? object_in(*value) : nullptr;
      if (held != nullptr) const pybind11::object let_go = std::exchange(*held, pybind11::object());
      return 0;
    };
  });
}

}  // namespace knuckle::python
