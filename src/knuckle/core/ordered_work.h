// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace knuckle {

/// Hands over what a job made. Deliveries are called in the order of their jobs, one at a time.
using Delivery = std::function<void()>;
/// Work on one item, done on any thread beside others.
using Job = std::function<Delivery()>;

/// Asks `next` for one job after another, in one thread at a time, until it returns an empty one; does the
/// jobs on all threads, and calls their deliveries. At most `in_flight` jobs (at least 1) lie between being
/// asked for and being delivered, so memory is bounded however many there are and however long one takes.
///
/// A thread that waits within a job or a delivery, in parallel work of its own, does not begin another job
/// meanwhile: the time that a job measures is its own. Parallel work within it is still shared with idle
/// threads.
///
/// An exception of `next`, a job or a delivery ends the work and is thrown on; what was delivered then is a
/// beginning without gaps. Where the program is asked to end (`is_interrupted`), no job is begun any more,
/// those that were are delivered, and Interrupted is thrown.
void run_in_order(const std::function<Job()>& next, int in_flight);

}  // namespace knuckle
