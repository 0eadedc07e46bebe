// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/ordered_work.h"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

#include "knuckle/core/parallel.h"
#include "knuckle/core/random.h"
#include "knuckle/core/testing.h"

namespace knuckle {
namespace {

void pause_us(std::uint32_t microseconds) {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
}

/// Jobs 0, ..., count - 1; `work(i)` is done in parallel, `deliver(i)` in order.
void run(int count, int in_flight, const std::function<void(int)>& work,
         const std::function<void(int)>& deliver) {
  int asked = 0;
  const auto next = [&]() -> Job {
    if (asked == count) return {};
    return [&, i = asked++]() -> Delivery {
      work(i);
      return [&, i] { deliver(i); };
    };
  };
  run_in_order(next, in_flight);
}

TEST(OrderedWorkTest, JobsOfVeryDifferentCostAreDeliveredInOrderOneAtATime) {
  std::vector<int> delivered;
  std::atomic<int> delivering = 0;
  run(
      300, 8,
      [](int i) {
        Random random(5, static_cast<std::uint64_t>(i));
        pause_us(i % 50 == 0 ? 5000 : random.below(100));
      },
      [&](int i) {
        EXPECT_EQ(++delivering, 1);
        pause_us(20);
        delivered.push_back(i);
        --delivering;
      });
  ASSERT_EQ(delivered.size(), 300u);
  for (int i = 0; i < 300; ++i) EXPECT_EQ(delivered[static_cast<std::size_t>(i)], i);
}

TEST(OrderedWorkTest, NoMoreJobsThanAllowedAreBetweenAskingAndDelivery) {
  std::atomic<int> alive = 0;
  std::atomic<int> most = 0;
  int asked = 0;
  const auto next = [&]() -> Job {
    if (asked++ == 200) return {};
    most = std::max(most.load(), ++alive);
    return [&, i = asked]() -> Delivery {
      pause_us(i == 1 ? 20000 : 10);  // the others run into the first
      return [&] { --alive; };
    };
  };
  run_in_order(next, 5);
  EXPECT_LE(most, 5);
  if (thread_count() > 1) {
    EXPECT_GE(most, 2) << "jobs were not done beside each other";
  }
  EXPECT_EQ(alive, 0);
}

TEST(OrderedWorkTest, AnExceptionOfAnyPartIsThrownOnAfterABeginningWithoutGaps) {
  for (const int part : {0, 1, 2}) {
    int delivered = 0;
    int asked = 0;
    const auto fail_in = [&](int this_part, int i) {
      if (part == this_part && i == 20) fail("part {}", part);
    };
    const auto next = [&]() -> Job {
      fail_in(0, asked);
      return [&, i = asked++]() -> Delivery {
        fail_in(1, i);
        return [&, i] {
          fail_in(2, i);
          EXPECT_EQ(i, delivered++);
        };
      };
    };
    EXPECT_EQ(testing::error_of([&] { run_in_order(next, 6); }), fmt::format("part {}", part));
    EXPECT_LE(delivered, 20);
  }
}

TEST(OrderedWorkTest, AJobThatWaitsForItsOwnParallelWorkDoesNoOther) {
  thread_local bool is_in_job = false;
  std::atomic<int> nested_jobs = 0;
  run(
      100, 8,
      [&](int) {
        if (is_in_job) ++nested_jobs;
        is_in_job = true;
        parallel_for(16, [](std::int64_t) { pause_us(50); });
        is_in_job = false;
      },
      [](int) {});
  EXPECT_EQ(nested_jobs, 0);
}

TEST(OrderedWorkTest, NothingToDo) {
  run(
      0, 4, [](int) { FAIL(); }, [](int) { FAIL(); });
}

}  // namespace
}  // namespace knuckle
