// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace knuckle {

/// How often durations occurred, in 25,000 classes that each span 0.1 per cent, from 0.1 us to 2 h: the
/// median of any number of durations to 0.1 per cent, in 100 kB.
class DurationHistogram {
 public:
  DurationHistogram();

  /// Counts a duration [ms]; what is shorter or longer than all classes counts in the first or last.
  void add(double duration_ms);
  std::int64_t count() const { return count_; }
  /// The median [ms] (of an even number the upper of the middle two); nothing where nothing was counted.
  std::optional<double> median_ms() const { return percentile_ms(50.0); }
  /// What so many per cent, [0, 100), of the durations do not exceed [ms].
  std::optional<double> percentile_ms(double percent) const;

 private:
  std::vector<std::uint32_t> counts_;
  std::int64_t count_ = 0;
};

}  // namespace knuckle
