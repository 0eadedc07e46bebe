// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bindings.h"

#include <chrono>
#include <future>

#include "knuckle/core/interruption.h"

namespace knuckle::python {

/// Waits a moment without the interpreter's lock.
template <class T>
bool is_done_soon(const std::future<T>& result) {
  const WithoutLock unlocked;
  return result.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
}

/// Asks the library's work to end, and waits until it has.
template <class T>
void end(const std::future<T>& result) {
  const WithoutLock unlocked;
  set_interrupted(true);
  result.wait();
  set_interrupted(false);
}

/// What `work` returns, which touches no Python object and may take long. It is done in another thread, since
/// only Python's first one can ask whether Ctrl-C was pressed: what its handler raises, KeyboardInterrupt,
/// then ends the work, and that of other threads with it.
template <class Work>
auto interruptible(const Work& work) {
  auto result = std::async(std::launch::async, [&work] {
    const Working working;
    return work();
  });
  while (!is_done_soon(result)) {
    if (PyErr_CheckSignals() == 0) continue;
    const pybind11::error_already_set raised;
    end(result);
    throw raised;
  }
  return result.get();
}

}  // namespace knuckle::python
