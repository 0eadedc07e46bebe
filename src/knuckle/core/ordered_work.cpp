// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/ordered_work.h"

#include <algorithm>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "knuckle/core/interruption.h"
#include "knuckle/core/thread_hand_over.h"

namespace knuckle {

void run_in_order(const std::function<Job()>& next, int in_flight) {
  bool has_ended_early = false;
  ThreadHandOver hand_over;
  const auto ask = [&](tbb::flow_control& control) -> Job {
    hand_over.take();
    has_ended_early = is_interrupted();
    Job job = has_ended_early ? Job() : next();
    if (!job) control.stop();
    hand_over.give();
    return job;
  };
  const auto work = [&](const Job& job) {
    hand_over.take();
    Delivery delivery = tbb::this_task_arena::isolate(job);
    hand_over.give();
    return delivery;
  };
  const auto deliver = [&](const Delivery& delivery) {
    hand_over.take();
    tbb::this_task_arena::isolate(delivery);
    hand_over.give();
  };
  hand_over.give();
  using enum tbb::filter_mode;
  tbb::parallel_pipeline(static_cast<std::size_t>(std::max(in_flight, 1)),
                         tbb::make_filter<void, Job>(serial_in_order, ask) &
                             tbb::make_filter<Job, Delivery>(parallel, work) &
                             tbb::make_filter<Delivery, void>(serial_in_order, deliver));
  hand_over.take();
  if (has_ended_early) end_if_interrupted();
}

}  // namespace knuckle
