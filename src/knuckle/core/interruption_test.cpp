// SPDX-License-Identifier: Apache-2.0
#include "knuckle/core/interruption.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include <gtest/gtest.h>
#include <unistd.h>

#include "knuckle/core/interrupted_by.h"
#include "knuckle/core/ordered_work.h"
#include "knuckle/core/parallel.h"

namespace knuckle {
namespace {

class InterruptionTest : public ::testing::Test {
 protected:
  void SetUp() override {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    std::signal(SIGINT, SIG_DFL);  // a shell's background jobs ignore it, and hand that on
  }
  void TearDown() override { set_interrupted(false); }
};

TEST_F(InterruptionTest, ParallelWorkEndsWhereItIsAskedTo) {
  std::atomic<int> done = 0;
  EXPECT_THROW(parallel_for(100000,
                            [&](std::int64_t) {
                              if (++done == 10) set_interrupted(true);
                            }),
               Interrupted);
  EXPECT_LT(done, 10000);
  EXPECT_THROW(end_if_interrupted(), Interrupted);
  set_interrupted(false);
  EXPECT_NO_THROW(parallel_for(10, [](std::int64_t) {}));
}

TEST_F(InterruptionTest, OneThreadsWorkEndsByItself) {
  std::atomic<bool> is_ended = false;
  const InterruptedBy own(is_ended);
  EXPECT_FALSE(is_interrupted());
  is_ended = true;
  EXPECT_THROW(end_if_interrupted(), Interrupted);
  std::thread([] { EXPECT_FALSE(is_interrupted()) << "that of others goes on"; }).join();
  const std::atomic<bool> is_inner_ended = false;
  {
    const InterruptedBy inner(is_inner_ended);
    EXPECT_FALSE(is_interrupted());
  }
  EXPECT_TRUE(is_interrupted());
}

TEST_F(InterruptionTest, OrderedWorkHandsOverWhatWasBegunAndThenEnds) {
  int begun = 0;
  int delivered = 0;
  const auto next = [&]() -> Job {
    const int number = begun++;
    if (begun == 50) set_interrupted(true);
    return [number, &delivered]() -> Delivery {
      return [number, &delivered] { EXPECT_EQ(number, delivered++); };
    };
  };
  EXPECT_THROW(run_in_order(next, 4), Interrupted);
  EXPECT_EQ(begun, 50);
  EXPECT_EQ(delivered, 50);
}

TEST_F(InterruptionTest, TheFirstSignalIsNotedAndTheSecondEndsTheProgram) {
  EXPECT_EXIT(
      {
        watch_for_interruption();
        std::raise(SIGINT);
        if (is_interrupted()) std::raise(SIGINT);
      },
      ::testing::KilledBySignal(SIGINT), "");
  EXPECT_EXIT(
      {
        watch_for_interruption();
        std::raise(SIGTERM);
        std::_Exit(is_interrupted() ? 7 : 8);
      },
      ::testing::ExitedWithCode(7), "");
}

TEST_F(InterruptionTest, OnlySignalsCountAsTheFirstAndTheSecond) {
  EXPECT_EXIT(
      {
        watch_for_interruption();
        set_interrupted(true);  // as where a disk is full
        std::raise(SIGTERM);
        set_interrupted(false);
        std::raise(SIGTERM);
        std::_Exit(is_interrupted() ? 7 : 8);
      },
      ::testing::ExitedWithCode(7), "");
}

TEST_F(InterruptionTest, ASignalThatIsHeldComesWhenItIsWatchedFor) {
  EXPECT_EXIT(
      {
        hold_interruption();
        std::raise(SIGTERM);
        if (is_interrupted()) std::_Exit(8);
        watch_for_interruption();
        std::_Exit(is_interrupted() ? 7 : 9);
      },
      ::testing::ExitedWithCode(7), "");
}

TEST_F(InterruptionTest, ASignalThatIsHeldWaitsAlsoWhereAnotherThreadTakesIt) {
  EXPECT_EXIT(
      {
        watch_for_interruption();
        std::thread([] { std::this_thread::sleep_for(std::chrono::minutes(1)); }).detach();
        hold_interruption();
        ::kill(::getpid(), SIGTERM);  // this thread does not take it
        sigset_t waiting;             // what execv hands on
        ::sigemptyset(&waiting);
        for (int look = 0; look < 10'000 && ::sigismember(&waiting, SIGTERM) == 0; ++look) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
          if (is_interrupted()) ::sigpending(&waiting);
        }
        std::_Exit(::sigismember(&waiting, SIGTERM) == 1 ? 7 : 8);
      },
      ::testing::ExitedWithCode(7), "");
}

TEST_F(InterruptionTest, ASignalThatWasIgnoredStaysIgnored) {
  EXPECT_EXIT(
      {
        std::signal(SIGINT, SIG_IGN);
        watch_for_interruption();
        std::raise(SIGINT);
        std::_Exit(is_interrupted() ? 8 : 7);
      },
      ::testing::ExitedWithCode(7), "");
}

}  // namespace
}  // namespace knuckle
