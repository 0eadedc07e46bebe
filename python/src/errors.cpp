// SPDX-License-Identifier: Apache-2.0
#include "bindings.h"

#include <filesystem>

#include <pybind11/pybind11.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"

namespace knuckle::python {
namespace {

// Lives as long as the process: exceptions may be translated until its very end.
PyObject* error_type = nullptr;

void set_error(PyObject* type, const char* message) {
  // Messages quote what users wrote, which need not be UTF-8, and Python's have to be.
  PyErr_SetString(type, printable(message).c_str());
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const Error& error) {
    set_error(error_type, error.what());
  } catch (const Interrupted& interrupted) {
    set_error(PyExc_KeyboardInterrupt, interrupted.what());
  } catch (const pybind11::cast_error&) {
    // Of a value within a list or dict; pybind11 would call this a RuntimeError.
    PyErr_SetString(PyExc_TypeError, "a value has another type than is expected there");
  } catch (const std::filesystem::filesystem_error& error) {
    set_error(PyExc_OSError, error.what());
  }
}

}  // namespace

void add_errors(pybind11::module_& module) {
  error_type = PyErr_NewExceptionWithDoc(
      "knuckle.Error",
      "A fault in what was handed over; the message is one line that names it and what was expected.",
      PyExc_ValueError, nullptr);
  module.attr("Error") = pybind11::handle(error_type);
  pybind11::register_exception_translator(translate);
}

}  // namespace knuckle::python
