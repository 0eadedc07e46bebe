// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/statistics.h"

#include <cmath>

#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(Statistics, MedianIsTheMiddleOfTheSortedValues) {
  Random random(3);
  for (std::size_t count = 1; count < 40; ++count) {
    std::vector<double> values(count);
    for (double& value : values) value = std::floor(random.uniform(-9.0, 9.0));  // some are equal
    std::vector<double> sorted = values;
    std::ranges::sort(sorted);
    EXPECT_EQ(median(values), (sorted[(count - 1) / 2] + sorted[count / 2]) / 2.0) << count << " values";
    EXPECT_EQ(upper_median(std::span(values)), sorted[count / 2]) << count << " values";
  }
}

TEST(Statistics, MeanIsTheSumOverTheNumber) {
  EXPECT_EQ(mean(std::vector{1.0, 2.0, 6.0}), 3.0);
  EXPECT_EQ(mean(std::vector{-1.5}), -1.5);
}

TEST(Statistics, OfNothingAreNotKnown) {
  EXPECT_TRUE(std::isnan(mean({})));
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Statistics, ARunningMeanIsThatOfAllValues) {
  RunningMean one;
  EXPECT_TRUE(std::isnan(one.value()));
  for (const double value : {1.0, 2.0, 6.0}) one.add(value);
  EXPECT_DOUBLE_EQ(one.value(), 3.0);
  RunningMean both;
  both.add(one);
  both.add(11.0);
  EXPECT_DOUBLE_EQ(both.value(), 5.0);
  EXPECT_EQ(both.count, 4);
}

TEST(Statistics, UpperMedianIsOneOfTheValues) {
  std::vector<float> values{4.0f, 1.0f, 3.0f, 2.0f};
  EXPECT_EQ(upper_median(std::span(values)), 3.0f);
}

}  // namespace
}  // namespace knuckle
