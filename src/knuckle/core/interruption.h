// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>

namespace knuckle {

/// Thrown where long work ends early because the program was asked to end. It is no Error: nothing is wrong
/// with the input, and nobody may work around it.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// From now on the first SIGINT (Ctrl-C) or SIGTERM makes `is_interrupted` true, and the second ends the
/// program at once. A signal that the program was started to ignore (as by nohup) stays ignored. For
/// programs; the library never calls it.
void watch_for_interruption();

/// From now on a SIGINT or SIGTERM waits for the next call of `watch_for_interruption`, in this program or in
/// the one that takes its place (`execv` by this thread): else one that comes while that is loaded would end
/// it without a word. Whether one has come before is to be asked after this call, not before it.
void hold_interruption();

/// Whether the program was asked to end, or this thread's work was (InterruptedBy). `parallel_for` and
/// `run_in_order` look at it before each item, other long loops by themselves. Safe to call from any thread.
bool is_interrupted();

/// Asks the running work to end, as Ctrl-C does, or takes that back (false). Safe to call from any thread and
/// in signal handlers: for programs with handlers of their own.
void set_interrupted(bool interrupted);

/// Throws Interrupted where the program was asked to end.
void end_if_interrupted();

}  // namespace knuckle
