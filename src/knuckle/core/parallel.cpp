// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/parallel.h"

#include <memory>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/thread_hand_over.h"

namespace knuckle {
namespace {

/// The limit that `set_thread_count` chose; none at the start.
std::unique_ptr<tbb::global_control>& thread_limit() {
  static std::unique_ptr<tbb::global_control> limit;
  return limit;
}

}  // namespace

int thread_count() {
  const auto limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return static_cast<int>(limit);
}

void set_thread_count(int count) {
  if (count < 0) fail("number of threads is {}, expected at least 0", count);
  thread_limit().reset();
  if (count == 0) return;
  thread_limit() = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                         static_cast<std::size_t>(count));
}

void parallel_for(std::int64_t count, const std::function<void(std::int64_t)>& work) {
  const auto task = [&](std::int64_t i) {
    const TaskHandOver hand_over;
    end_if_interrupted();
    work(i);
  };
  const WorkHandOver whole_work;
  tbb::parallel_for(std::int64_t{0}, count, task);
}

}  // namespace knuckle
