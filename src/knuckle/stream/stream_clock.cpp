// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/stream_clock.h"

#include <algorithm>
#include <cmath>

namespace knuckle {
namespace {

constexpr double kMostAheadSeconds = 1.0;

}  // namespace

double StreamClock::time_s(std::optional<double> stamp_s, double arrival_s) {
  if (!first_arrival_s_) first_arrival_s_ = arrival_s;
  const double since_first = arrival_s - *first_arrival_s_;
  if (stamp_s && std::isfinite(*stamp_s) && !offset_s_) offset_s_ = std::max(since_first, last_s_) - *stamp_s;
  const double by_device = stamp_s && offset_s_ ? *stamp_s + *offset_s_ : since_first;
  const bool is_likely = by_device >= last_s_ && by_device <= since_first + kMostAheadSeconds;
  last_s_ = is_likely ? by_device : std::max(last_s_, since_first);
  return last_s_;
}

void StreamClock::restart_device() {
  offset_s_.reset();
}

}  // namespace knuckle
