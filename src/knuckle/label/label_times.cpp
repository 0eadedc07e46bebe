// SPDX-License-Identifier: Apache-2.0
#include "knuckle/label/label_times.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "knuckle/core/statistics.h"

namespace knuckle {

LabelTimes times_of(const LabelBook& book) {
  std::map<std::int64_t, double> of_frames;
  for (const auto& [hand, history] : book.hands()) {
    const auto is_work = [](const LabelChange& change) { return is_of_person(change.act); };
    if (std::ranges::any_of(history.changes, is_work)) of_frames[hand.frame] += history.seconds();
  }
  std::vector<double> seconds;
  for (const auto& [frame, s] : of_frames) seconds.push_back(s);
  LabelTimes times{.frames = std::ssize(seconds),
                   .total_s = std::accumulate(seconds.begin(), seconds.end(), 0.0)};
  if (seconds.empty()) return times;
  std::ranges::sort(seconds);
  const auto last = static_cast<std::size_t>(std::ceil(0.9 * static_cast<double>(seconds.size())));
  times.percentile90_s = seconds[last - 1];
  times.median_s = median(std::move(seconds));
  return times;
}

}  // namespace knuckle
