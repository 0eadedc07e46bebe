// SPDX-License-Identifier: Apache-2.0
#include "knuckle/storage/work_claim.h"

#include <atomic>
#include <csignal>
#include <thread>
#include <vector>

#include <sys/wait.h>
#include <unistd.h>

#include "knuckle/core/interruption.h"
#include "knuckle/core/testing.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::HasSubstr;

class WorkClaimTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "work.claim";
};

TEST_F(WorkClaimTest, IsOnesAtATime) {
  std::atomic<int> inside = 0;
  std::atomic<int> most = 0;
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      for (int turn = 0; turn < 3; ++turn) {
        const WorkClaim claim(file_);
        most = std::max<int>(most, ++inside);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
        --inside;
      }
    });
  }
  threads.clear();
  EXPECT_EQ(most, 1);
  EXPECT_FALSE(std::filesystem::exists(file_)) << "it leaves nothing";
}

TEST_F(WorkClaimTest, SaysOnceThatItWaits) {
  int waits = 0;
  {
    const WorkClaim claim(file_, [&] { ++waits; });
  }
  EXPECT_EQ(waits, 0);
  std::atomic<bool> waited = false;
  std::jthread other;
  {
    const WorkClaim claim(file_);
    other = std::jthread([&] {
      const WorkClaim second(file_, [&] {
        ++waits;
        waited = true;
      });
    });
    while (!waited) std::this_thread::yield();
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
  }
  other.join();
  EXPECT_EQ(waits, 1);
}

TEST_F(WorkClaimTest, EndsWithItsProcess) {
  const pid_t child = ::fork();
  if (child == 0) {
    const WorkClaim claim(file_);
    write_text_file(folder_ / "has_it", "");
    ::pause();
    ::_exit(0);
  }
  while (!std::filesystem::exists(folder_ / "has_it")) std::this_thread::yield();
  bool waited = false;
  const WorkClaim claim(file_, [&] {
    waited = true;
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  });
  EXPECT_TRUE(waited);
}

TEST_F(WorkClaimTest, TakesOverAFileThatIsLeft) {
  write_text_file(file_, "left");
  bool waited = false;
  const WorkClaim claim(file_, [&] { waited = true; });
  EXPECT_FALSE(waited);
}

TEST_F(WorkClaimTest, WaitingEndsWhereTheProgramIsAskedToEnd) {
  const WorkClaim claim(file_);
  EXPECT_THROW(WorkClaim(file_, [] { set_interrupted(true); }), Interrupted);
  set_interrupted(false);
}

TEST_F(WorkClaimTest, NamesAFileThatCannotBeLocked) {
  EXPECT_THAT(error_of([&] { WorkClaim(folder_ / "none" / "work.claim"); }),
              HasSubstr("work.claim: cannot be locked"));
}

}  // namespace
}  // namespace knuckle::testing
