// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/ordered_work.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <memory>

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

struct Item {
  Job job;
  Delivery delivery;
};

}  // namespace

// No exception crosses oneTBB: where one does, items that are on their way are never destroyed. Items go
// through it as pointers, which it keeps as they are: so all that threads hand to each other is handed over
// here.
void run_in_order(const std::function<Job()>& next, int in_flight) {
  std::atomic<bool> has_ended = false;  // a fault was delivered
  bool is_all_asked = false;
  std::exception_ptr fault;
  const auto ask = [&](tbb::flow_control& control) -> Item* {
    const TaskHandOver hand_over;
    auto item = std::make_unique<Item>();
    try {
      if (!is_all_asked) end_if_interrupted();
      if (!has_ended && !is_all_asked) item->job = next();
    } catch (...) {
      is_all_asked = true;
      item->job = [fails = fault_delivery()] { return fails; };
    }
    if (!item->job) {
      control.stop();
      item.reset();
    }
    return item.release();
  };
  const auto work = [&](Item* item) -> Item* {
    const TaskHandOver hand_over;
    try {
      if (!has_ended) item->delivery = tbb::this_task_arena::isolate(item->job);
    } catch (...) {
      item->delivery = fault_delivery();
    }
    return item;
  };
  const auto deliver = [&](Item* delivered) {
    const TaskHandOver hand_over;
    const std::unique_ptr<Item> item(delivered);
    try {
      if (!has_ended) tbb::this_task_arena::isolate(item->delivery);
    } catch (...) {
      fault = std::current_exception();
      has_ended = true;
    }
  };
  ThreadHandOver::give();
  using enum tbb::filter_mode;
  tbb::parallel_pipeline(static_cast<std::size_t>(std::max(in_flight, 1)),
                         tbb::make_filter<void, Item*>(serial_in_order, ask) &
                             tbb::make_filter<Item*, Item*>(parallel, work) &
                             tbb::make_filter<Item*, void>(serial_in_order, deliver));
  ThreadHandOver::take();
  if (fault) std::rethrow_exception(fault);
}

}  // namespace knuckle
