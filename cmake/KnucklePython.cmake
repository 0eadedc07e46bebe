# SPDX-License-Identifier: Apache-2.0
# Python: to run tests and scripts with, and to build the package `knuckle` (python/) for.

# Not any python3 of the path: numpy, h5py and pybind11 are Debian's.
find_program(KNUCKLE_PYTHON_PROGRAM python3 PATHS /usr/bin NO_DEFAULT_PATH)
option(KNUCKLE_PYTHON "Build the Python package where pybind11 and Python's headers are found" ON)

# Says in KNUCKLE_NO_PYTHON why the package is not built; empty: it is.
set(KNUCKLE_NO_PYTHON "")
if(NOT KNUCKLE_PYTHON)
  set(KNUCKLE_NO_PYTHON "KNUCKLE_PYTHON is off")
elseif(KNUCKLE_SANITIZE OR KNUCKLE_FUZZ)
  set(KNUCKLE_NO_PYTHON "an interpreter without sanitizers cannot load libraries with them")
elseif(CMAKE_CROSSCOMPILING)
  set(KNUCKLE_NO_PYTHON "this builds for another machine")
elseif(NOT KNUCKLE_PYTHON_PROGRAM)
  set(KNUCKLE_NO_PYTHON "there is no /usr/bin/python3; KNUCKLE_PYTHON_PROGRAM names another")
else()
  set(Python_EXECUTABLE ${KNUCKLE_PYTHON_PROGRAM})
  set(PYBIND11_FINDPYTHON ON)
  find_package(Python 3.9 QUIET COMPONENTS Interpreter Development.Module)
  if(Python_FOUND)
    find_package(pybind11 2.10 CONFIG QUIET)
  endif()
  if(NOT Python_FOUND)
    set(KNUCKLE_NO_PYTHON "Python's headers were not found (python3-dev)")
  elseif(NOT pybind11_FOUND)
    set(KNUCKLE_NO_PYTHON "pybind11 was not found (pybind11-dev)")
  endif()
endif()

if(KNUCKLE_NO_PYTHON)
  message(STATUS "Python package: not built, ${KNUCKLE_NO_PYTHON}")
else()
  message(STATUS "Python package: built for Python ${Python_VERSION} with pybind11 ${pybind11_VERSION}")
endif()
