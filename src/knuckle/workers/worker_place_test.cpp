// SPDX-License-Identifier: Apache-2.0
#include "knuckle/workers/worker_place.h"

#include <cstdlib>

#include "knuckle/core/testing.h"
#include "knuckle/core/testing_variable.h"
#include "knuckle/workers/local_workers.h"

namespace knuckle {
namespace {

using testing::error_of;
using ::testing::HasSubstr;

/// Begins without a variable that says where workers meet, and takes away what a test has set.
class WorkerPlaceTest : public ::testing::Test {
 protected:
  WorkerPlaceTest() { clear(); }
  ~WorkerPlaceTest() override { clear(); }
  static void set(const char* name, const char* value) { ::setenv(name, value, 1); }
  static void clear() {
    for (const char* const name :
         {kRankVariable, kFolderVariable, "RANK", "WORLD_SIZE", "MASTER_ADDR", "MASTER_PORT", "LOCAL_RANK",
          "SLURM_STEP_NUM_TASKS", "SLURM_PROCID", "SLURM_LOCALID", "SLURM_STEP_NODELIST", "SLURM_JOB_ID"}) {
      ::unsetenv(name);
    }
  }
};

TEST_F(WorkerPlaceTest, WithoutVariablesIsWorker0OfThisMachine) {
  const WorkerPlace place = worker_place(3);
  EXPECT_EQ(place.rank, 0);
  EXPECT_EQ(place.size, 3);
  EXPECT_TRUE(place.is_on_one_machine());
}

TEST_F(WorkerPlaceTest, EmptyVariablesAreAsGoodAsNone) {
  for (const char* const name : {kRankVariable, "RANK", "SLURM_STEP_NUM_TASKS"}) set(name, "");
  EXPECT_TRUE(worker_place(3).is_on_one_machine());
}

TEST_F(WorkerPlaceTest, OfAStepOfSlurmIsItsTask) {
  set("SLURM_STEP_NUM_TASKS", "4");
  set("SLURM_PROCID", "2");
  set("SLURM_STEP_NODELIST", "node[07-08]");
  set("SLURM_JOB_ID", "31234");
  const WorkerPlace place = worker_place(4);
  EXPECT_EQ(place.rank, 2);
  EXPECT_EQ(place.address, "node07");
  EXPECT_EQ(place.port, 21234);
  EXPECT_EQ(place.number_on_machine, 2) << "nothing says that others of the four are elsewhere";
  set("SLURM_LOCALID", "1");
  EXPECT_EQ(worker_place(4).number_on_machine, 1);
  EXPECT_THAT(error_of([] { worker_place(3); }), HasSubstr("--workers 4"));
  set("SLURM_PROCID", "4");
  EXPECT_THAT(error_of([] { worker_place(4); }), HasSubstr("worker 4 of 4"));
  EXPECT_EQ(worker_place(1).size, 1) << "who does not ask for workers works alone";
}

TEST_F(WorkerPlaceTest, OfOneTaskOfSlurmIsThisMachine) {
  set("SLURM_STEP_NUM_TASKS", "1");
  set("SLURM_PROCID", "0");
  EXPECT_TRUE(worker_place(2).is_on_one_machine());
}

TEST_F(WorkerPlaceTest, IsTakenFromTheVariablesOfPyTorchFirst) {
  set("SLURM_STEP_NUM_TASKS", "4");
  set("RANK", "1");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("WORLD_SIZE is not"));
  set("WORLD_SIZE", "2");
  set("MASTER_ADDR", "::1");
  set("MASTER_PORT", "70000");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("MASTER_PORT is 70000"));
  set("MASTER_PORT", "7000");
  EXPECT_EQ(worker_place(2).rank, 1);
  EXPECT_EQ(worker_place(2).port, 7000);
  EXPECT_EQ(worker_place(2).number_on_machine, 1);
  set("LOCAL_RANK", "0");
  EXPECT_EQ(worker_place(2).number_on_machine, 0) << "the first of another machine";
  set("RANK", "one");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("RANK"));
}

TEST_F(WorkerPlaceTest, OfOneThatWasStartedIsWithAllOthers) {
  set(kRankVariable, "1");
  EXPECT_THAT(error_of([] { worker_place(2); }),
              HasSubstr("KNUCKLE_WORKER is set, and KNUCKLE_WORKERS_FOLDER is not"));
  set(kFolderVariable, "/meeting");
  EXPECT_EQ(worker_place(2).folder, "/meeting");
  EXPECT_EQ(worker_place(2).number_on_machine, 1);
  set(kRankVariable, "2");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("this is worker 2 of 2"));
  set(kRankVariable, "-1");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("KNUCKLE_WORKER is -1, expected a number from 0"));
}

TEST_F(WorkerPlaceTest, WithoutAPortOrAnAddressNobodyMeets) {
  set("RANK", "0");
  set("WORLD_SIZE", "2");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("RANK is set, and MASTER_ADDR is not"));
  set("MASTER_ADDR", "::1");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("RANK is set, and MASTER_PORT is not"));
  set("MASTER_PORT", "0");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("MASTER_PORT is 0, expected a number from 1"));
}

TEST_F(WorkerPlaceTest, AStepOfSlurmSaysItsTaskAndItsNodes) {
  set("SLURM_STEP_NUM_TASKS", "2");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("SLURM_PROCID is not"));
  set("SLURM_PROCID", "1");
  EXPECT_THAT(error_of([] { worker_place(2); }), HasSubstr("SLURM_STEP_NODELIST is not"));
}

TEST_F(WorkerPlaceTest, WhereNoFolderCanBeMadeWorkersCannotMeet) {
  const testing::ChangedVariable folder("TMPDIR", "/proc");  // where nobody can make a folder
  const std::string error = error_of([] { LocalWorkers workers({}, 1); });
  EXPECT_THAT(error, HasSubstr("/proc/knuckle-workers-"));
  EXPECT_THAT(error, HasSubstr("cannot be made, for the workers to meet in"));
}

TEST(FirstHost, IsReadFromTheListsOfSlurm) {
  EXPECT_EQ(first_host("alone"), "alone");
  EXPECT_EQ(first_host("one,two"), "one");
  EXPECT_EQ(first_host("node[07-09,12],other"), "node07");
  EXPECT_EQ(first_host("n[3,5]-ib"), "n3-ib");
  EXPECT_EQ(first_host("broken[1"), "broken1");
  EXPECT_EQ(first_host(""), "");
}

}  // namespace
}  // namespace knuckle
