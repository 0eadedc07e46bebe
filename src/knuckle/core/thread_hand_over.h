// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace knuckle {

/// What threads of oneTBB hand to each other, told to the thread sanitizer: that library is not compiled for
/// it, so it sees no order between who starts a task and who runs it. Without the sanitizer this does
/// nothing.
///
/// One hand-over serves all: to tell them apart, tasks would have to read what they were not handed yet.
class ThreadHandOver {
 public:
  /// All that this thread did so far is seen by those who take later.
  static void give() {
#ifdef __SANITIZE_THREAD__
    __tsan_release(&place_);
#endif
  }

  /// Sees all that was given so far.
  static void take() {
#ifdef __SANITIZE_THREAD__
    __tsan_acquire(&place_);
#endif
  }

#ifdef __SANITIZE_THREAD__
 private:
  inline static char place_ = 0;
#endif
};

/// Takes as a task begins, and gives as it ends, by an exception or not.
class TaskHandOver {
 public:
  TaskHandOver() { ThreadHandOver::take(); }
  ~TaskHandOver() { ThreadHandOver::give(); }
  TaskHandOver(const TaskHandOver&) = delete;
  TaskHandOver& operator=(const TaskHandOver&) = delete;
};

/// Gives as work for tasks begins, and takes when all of them have ended, by an exception or not.
class WorkHandOver {
 public:
  WorkHandOver() { ThreadHandOver::give(); }
  ~WorkHandOver() { ThreadHandOver::take(); }
  WorkHandOver(const WorkHandOver&) = delete;
  WorkHandOver& operator=(const WorkHandOver&) = delete;
};

}  // namespace knuckle
