// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/parallel.h"

#include <atomic>
#include <vector>

#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

TEST(ParallelTest, EveryIndexIsVisitedOnce) {
  std::vector<std::atomic<int>> visits(1000);
  parallel_for(1000, [&](std::int64_t i) { ++visits[static_cast<std::size_t>(i)]; });
  for (const auto& count : visits) EXPECT_EQ(count, 1);
  parallel_for(0, [](std::int64_t) { FAIL(); });
}

TEST(ParallelTest, AnExceptionReachesTheCaller) {
  EXPECT_THAT(testing::error_of([] {
                parallel_for(100, [](std::int64_t i) {
                  if (i == 50) fail("fifty");
                });
              }),
              ::testing::HasSubstr("fifty"));
}

TEST(ParallelTest, TheThreadCountIsWhatWasSet) {
  set_thread_count(1);
  EXPECT_EQ(thread_count(), 1);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
  EXPECT_THAT(testing::error_of([] { set_thread_count(-1); }), ::testing::HasSubstr("-1"));
}

}  // namespace
}  // namespace knuckle
