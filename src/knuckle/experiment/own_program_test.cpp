// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/own_program.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <sys/wait.h>

#include "knuckle/core/testing.h"

namespace knuckle::testing {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// "This program" is the test program; the disabled tests below are what its children do.
std::vector<std::string> child(const std::string& name) {
  return {"--gtest_also_run_disabled_tests", "--gtest_filter=OwnProgramChild.DISABLED_" + name};
}

TEST(OwnProgramChild, DISABLED_Succeeds) {
  std::fprintf(stderr, "work: 1 of 2\nwork: 2 of 2\n");
}

TEST(OwnProgramChild, DISABLED_Fails) {
  std::fprintf(stderr, "work: 1 of 2\nknuckle: set.toml:3: depth: is missing\n");
  std::_Exit(1);
}

TEST(OwnProgramChild, DISABLED_FailsSilently) {
  std::_Exit(1);
}

TEST(OwnProgramChild, DISABLED_IsKilled) {
  std::raise(SIGKILL);
}

TEST(OwnProgramChild, DISABLED_IsNotStarted) {
  std::_Exit(127);  // as where the system refuses to start it
}

TEST(OwnProgramTest, PassesOnWhatTheChildSays) {
  ::testing::internal::CaptureStderr();
  run_own_program(child("Succeeds"));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "work: 1 of 2\nwork: 2 of 2\n");
}

TEST(OwnProgramTest, ThrowsTheLastLineOfAChildThatFails) {
  ::testing::internal::CaptureStderr();
  const std::string error = error_of([] { run_own_program(child("Fails")); });
  EXPECT_EQ(error, "set.toml:3: depth: is missing");
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), AllOf(HasSubstr("1 of 2"), Not(HasSubstr("depth"))));
}

TEST(OwnProgramTest, SaysHowAChildEndedThatSaidNothing) {
  EXPECT_THAT(error_of([] { run_own_program(child("FailsSilently")); }), HasSubstr("failed without a word"));
  EXPECT_THAT(error_of([] { run_own_program(child("IsKilled")); }), HasSubstr("was ended by signal 9"));
  EXPECT_THAT(error_of([] { run_own_program(child("IsNotStarted")); }), HasSubstr("could not be started"));
}

TEST(OwnProgramTest, IsStartedByAnotherCommand) {
  run_own_program(child("Succeeds"), {"/usr/bin/env"});
  EXPECT_THAT(error_of([] { run_own_program(child("Succeeds"), {"no_such_starter"}); }),
              HasSubstr("could not be started"));
}

TEST(OwnProgramTest, TakesTheErrorLineAlsoWhereTheStarterSaysMore) {
  const std::vector<std::string> starter = {
      "/bin/sh", "-c", "\"$@\"; status=$?; echo 'srun: error: task 0: exited' >&2; exit $status", "sh"};
  ::testing::internal::CaptureStderr();
  const std::string error = error_of([&] { run_own_program(child("Fails"), starter); });
  EXPECT_EQ(error, "set.toml:3: depth: is missing");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "work: 1 of 2\nsrun: error: task 0: exited\n");
}

TEST(OwnProgramTest, LeavesNoZombie) {
  run_own_program(child("Succeeds"));
  EXPECT_NE(error_of([] { run_own_program(child("FailsSilently")); }), "");
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "there is a child that nobody waited for";
}

}  // namespace
}  // namespace knuckle::testing
