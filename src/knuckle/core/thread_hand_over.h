// SPDX-License-Identifier: Apache-2.0
#pragma once

#ifdef __SANITIZE_THREAD__
#include <sanitizer/tsan_interface.h>
#endif

namespace knuckle {

/// What threads of oneTBB hand to each other, told to the thread sanitizer: that library is not compiled for
/// it, so it sees no order between who starts a task and who runs it. Without the sanitizer this does
/// nothing.
class ThreadHandOver {
 public:
  /// All that this thread did so far is seen by those who take later.
  void give() {
#ifdef __SANITIZE_THREAD__
    __tsan_release(this);
#endif
  }

  /// Sees all that was given so far.
  void take() {
#ifdef __SANITIZE_THREAD__
    __tsan_acquire(this);
#endif
  }
};

}  // namespace knuckle
