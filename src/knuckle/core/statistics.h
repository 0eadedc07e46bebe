// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace knuckle {

/// The mean of the values, all of which are numbers; NaN where there are none.
double mean(std::span<const double> values);

/// The median of the values, all of which are numbers: the mean of the middle two where their number is even;
/// NaN where there are none.
double median(std::vector<double> values);

/// The value in the middle of the sorted values, the upper of the middle two where their number is even: one
/// of the values, whatever their type. `values` are not empty, and are brought into another order.
template <class T>
T upper_median(std::span<T> values) {
  assert(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

/// A mean of values that come one by one, or of several such means.
struct RunningMean {
  double sum = 0.0;
  std::int64_t count = 0;

  void add(double value) {
    sum += value;
    ++count;
  }
  void add(const RunningMean& other) {
    sum += other.sum;
    count += other.count;
  }
  /// NaN where nothing was added.
  double value() const {
    return count == 0 ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(count);
  }
};

}  // namespace knuckle
