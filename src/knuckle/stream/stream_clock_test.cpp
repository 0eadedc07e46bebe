// SPDX-License-Identifier: Apache-2.0
#include "knuckle/stream/stream_clock.h"

#include <gtest/gtest.h>

namespace knuckle {
namespace {

TEST(StreamClock, BeginsAtZeroAndKeepsTheDevicesSteps) {
  StreamClock clock;
  EXPECT_DOUBLE_EQ(clock.time_s(100.0, 5000.0), 0.0);
  EXPECT_DOUBLE_EQ(clock.time_s(100.03125, 5000.5), 0.03125) << "it came late, but was taken then";
  EXPECT_DOUBLE_EQ(clock.time_s(100.0625, 5000.0625), 0.0625);
}

TEST(StreamClock, WithoutStampsItIsTheArrivalThatCounts) {
  StreamClock clock;
  EXPECT_DOUBLE_EQ(clock.time_s(std::nullopt, 7.0), 0.0);
  EXPECT_DOUBLE_EQ(clock.time_s(std::nullopt, 7.5), 0.5);
}

TEST(StreamClock, NeverGoesBack) {
  StreamClock clock;
  clock.time_s(100.0, 10.0);
  EXPECT_DOUBLE_EQ(clock.time_s(100.25, 10.25), 0.25);
  EXPECT_DOUBLE_EQ(clock.time_s(3.0, 10.5), 0.5) << "a stamp that goes back is no stamp";
  EXPECT_DOUBLE_EQ(clock.time_s(100.25, 10.5), 0.5);
  EXPECT_DOUBLE_EQ(clock.time_s(100.75, 10.75), 0.75);
}

TEST(StreamClock, NeverGoesBackToTheArrivalsWhereTheDeviceIsAhead) {
  StreamClock clock;
  clock.time_s(100.0, 10.0);
  EXPECT_DOUBLE_EQ(clock.time_s(100.75, 10.25), 0.75);
  EXPECT_DOUBLE_EQ(clock.time_s(3.0, 10.5), 0.75) << "neither the stamp nor the arrival may be told";
  clock.restart_device();
  EXPECT_DOUBLE_EQ(clock.time_s(5.0, 10.5), 0.75);
  EXPECT_DOUBLE_EQ(clock.time_s(5.25, 10.75), 1.0) << "it goes on from the last frame";
}

TEST(StreamClock, ALeapIsReplacedByTheArrival) {
  StreamClock clock;
  clock.time_s(100.0, 10.0);
  EXPECT_DOUBLE_EQ(clock.time_s(1e9, 10.5), 0.5);
  EXPECT_DOUBLE_EQ(clock.time_s(101.0, 11.0), 1.0);
}

TEST(StreamClock, GoesOnAfterTheDeviceBeganAnew) {
  StreamClock clock;
  clock.time_s(100.0, 10.0);
  clock.time_s(101.0, 11.0);
  clock.restart_device();
  EXPECT_DOUBLE_EQ(clock.time_s(0.5, 20.0), 10.0);
  EXPECT_DOUBLE_EQ(clock.time_s(0.75, 20.5), 10.25);
}

}  // namespace
}  // namespace knuckle
