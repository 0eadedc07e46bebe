// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/duration_histogram.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "knuckle/core/random.h"

namespace knuckle {
namespace {

TEST(DurationHistogramTest, ItsMedianIsThatOfTheSortedDurations) {
  Random random(3, 0);
  for (const int count : {1, 2, 3, 10, 1001}) {
    DurationHistogram histogram;
    std::vector<double> durations;
    for (int i = 0; i < count; ++i) {
      durations.push_back(std::exp(random.uniform(std::log(1e-3), std::log(1e6))));
      histogram.add(durations.back());
    }
    std::ranges::sort(durations);
    const double exact = durations[durations.size() / 2];
    EXPECT_NEAR(*histogram.median_ms() / exact, 1.0, 1e-3) << count;
    EXPECT_EQ(histogram.count(), count);
  }
}

TEST(DurationHistogramTest, APercentileIsWhatSoManyDoNotExceed) {
  DurationHistogram histogram;
  EXPECT_FALSE(histogram.percentile_ms(99.0));
  for (int i = 1; i <= 1000; ++i) histogram.add(i);
  for (const double percent : {0.0, 10.0, 50.0, 99.0})
    EXPECT_NEAR(*histogram.percentile_ms(percent), 10.0 * percent + 1.0, 1.1e-3 * (10.0 * percent + 1.0));
}

TEST(DurationHistogramTest, ExtremesCountInTheOutermostClasses) {
  DurationHistogram histogram;
  EXPECT_FALSE(histogram.median_ms());
  histogram.add(0.0);
  EXPECT_NEAR(*histogram.median_ms(), 1e-4, 1e-6);
  for (int i = 0; i < 3; ++i) histogram.add(1e30);
  EXPECT_GT(*histogram.median_ms(), 7e6);
}

}  // namespace
}  // namespace knuckle
