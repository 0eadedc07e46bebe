// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/ordered_work.h"

#include <algorithm>
#include <atomic>
#include <exception>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include "knuckle/core/interruption.h"
#include "knuckle/core/thread_hand_over.h"

namespace knuckle {
namespace {

/// A delivery that throws what its job, or asking for it, has thrown: errors, too, come in the order of the
/// jobs.
Delivery fault_delivery() {
  return [fault = std::current_exception()] { std::rethrow_exception(fault); };
}

}  // namespace

// No exception crosses oneTBB: where one does, items that are on their way are never destroyed.
void run_in_order(const std::function<Job()>& next, int in_flight) {
  std::atomic<bool> has_ended = false;  // a fault was delivered
  bool is_all_asked = false;
  std::exception_ptr fault;
  ThreadHandOver hand_over;
  const auto ask = [&](tbb::flow_control& control) -> Job {
    hand_over.take();
    Job job;
    try {
      if (!is_all_asked) end_if_interrupted();
      if (!has_ended && !is_all_asked) job = next();
    } catch (...) {
      is_all_asked = true;
      job = [fails = fault_delivery()] { return fails; };
    }
    if (!job) control.stop();
    hand_over.give();
    return job;
  };
  const auto work = [&](const Job& job) -> Delivery {
    hand_over.take();
    Delivery delivery;
    try {
      if (!has_ended) delivery = tbb::this_task_arena::isolate(job);
    } catch (...) {
      delivery = fault_delivery();
    }
    hand_over.give();
    return delivery;
  };
  const auto deliver = [&](const Delivery& delivery) {
    hand_over.take();
    try {
      if (!has_ended) tbb::this_task_arena::isolate(delivery);
    } catch (...) {
      fault = std::current_exception();
      has_ended = true;
    }
    hand_over.give();
  };
  hand_over.give();
  using enum tbb::filter_mode;
  tbb::parallel_pipeline(static_cast<std::size_t>(std::max(in_flight, 1)),
                         tbb::make_filter<void, Job>(serial_in_order, ask) &
                             tbb::make_filter<Job, Delivery>(parallel, work) &
                             tbb::make_filter<Delivery, void>(serial_in_order, deliver));
  hand_over.take();
  if (fault) std::rethrow_exception(fault);
}

}  // namespace knuckle
