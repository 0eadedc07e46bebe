// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <cxxabi.h>
#include <pybind11/pybind11.h>

namespace knuckle::python {

/// From now on the process ends, after its interpreter, when the library's works have: they are asked to, and
/// threads that want the lock of an interpreter that is gone sleep. Called once.
void watch_for_the_interpreters_end();

bool is_interpreter_gone();

/// This thread does nothing more, and ends with the process.
[[noreturn]] void sleep_for_ever();

/// What `call` gives, which asks for the interpreter's lock or runs Python code. Where the interpreter ends
/// before another thread has the lock, that thread never returns from here: Python up to 3.13 ends it by
/// unwinding its stack, which C++ does not survive (no destructor may be left so), so it sleeps, as it does
/// from Python 3.14 on.
template <class Call>
auto in_python(const Call& call) {
  if (is_interpreter_gone()) sleep_for_ever();
  try {
    return call();
  } catch (const abi::__forced_unwind&) {
    sleep_for_ever();
  }
}

/// Work of the library goes on in this thread while such an object lives.
class Working {
 public:
  Working();
  ~Working();
  Working(const Working&) = delete;
  Working& operator=(const Working&) = delete;
};

/// The interpreter's lock is released while such an object lives: for computing that touches no Python
/// object. In place of pybind11's own, which does not survive the interpreter's end (`in_python`).
class WithoutLock {
 public:
  WithoutLock() : thread_(PyEval_SaveThread()) { working_.emplace(); }
  ~WithoutLock() {
    working_.reset();
    in_python([&] { PyEval_RestoreThread(thread_); });
  }
  WithoutLock(const WithoutLock&) = delete;
  WithoutLock& operator=(const WithoutLock&) = delete;

 private:
  PyThreadState* thread_;
  std::optional<Working> working_;
};

/// The interpreter's lock is held while such an object lives, from any thread.
class WithLock {
 public:
  WithLock() : before_(in_python([] { return PyGILState_Ensure(); })) {}
  ~WithLock() { PyGILState_Release(before_); }
  WithLock(const WithLock&) = delete;
  WithLock& operator=(const WithLock&) = delete;

 private:
  PyGILState_STATE before_;
};

}  // namespace knuckle::python
