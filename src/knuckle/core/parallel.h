// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>

namespace knuckle {

/// Number of threads that parallel work uses: `set_thread_count`, or one per core.
int thread_count();

/// Sets that number for the whole program; 0 = one per core. Call it before parallel work, from the main
/// thread.
void set_thread_count(int count);

/// Calls `work(i)` for each i in [0, count), on all threads, in no order. An exception of one call ends the
/// others as soon as it can and is thrown on; so does Interrupted where the program is asked to end.
void parallel_for(std::int64_t count, const std::function<void(std::int64_t)>& work);

}  // namespace knuckle
