// SPDX-License-Identifier: Apache-2.0
#include "interpreter_lock.h"

#include <atomic>
#include <chrono>
#include <thread>

#include <pthread.h>
#include <unistd.h>

#include "knuckle/core/interruption.h"

namespace knuckle::python {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::seconds kLongestWait{5};

std::atomic<bool> is_gone = false;
std::atomic<int> works_at_once = 0;
thread_local int works_of_thread = 0;

/// What comes next destroys the library's own tables.
void wait_for_works() {
  const auto end = Clock::now() + kLongestWait;
  while (works_at_once > 0 && Clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void end_with_interpreter() {
  is_gone = true;
  set_interrupted(true);
  wait_for_works();
}

}  // namespace

void watch_for_the_interpreters_end() {
  Py_AtExit(end_with_interpreter);
  // A forked process has this thread alone.
  ::pthread_atfork(nullptr, nullptr, [] { works_at_once = works_of_thread; });
}

bool is_interpreter_gone() {
  return is_gone;
}

void sleep_for_ever() {
  works_at_once -= works_of_thread;
  while (true) ::pause();
}

Working::Working() {
  ++works_of_thread;
  ++works_at_once;
}

Working::~Working() {
  --works_of_thread;
  --works_at_once;
}

}  // namespace knuckle::python
