// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/statistics.h"

#include <limits>
#include <numeric>

namespace knuckle {

double mean(std::span<const double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double upper = upper_median(std::span(values));
  if (values.size() % 2 == 1) return upper;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  return (upper + *std::max_element(values.begin(), middle)) /
         2.0;  // those before the middle are the lower half
}

}  // namespace knuckle
