// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/slurm_queue.h"

#include <cstdlib>

#include "knuckle/core/error.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/experiment/captured_command.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

ExperimentStep step_named(const std::string& name) {
  ExperimentStep step;
  step.name = name;
  step.output = "/out/" + name;
  return step;
}

TEST(SbatchCommandTest, HasTheUsersOptionsBeforeOurs) {
  const SlurmOptions options{{"--partition=gpu", "--cpus-per-task=8"}, {"/bin/knuckle", "experiment"}, 4};
  EXPECT_THAT(
      sbatch_command(step_named("poses/a.txt"), "/out/100%/a.log", options),
      ElementsAre("sbatch", "--parsable", "--partition=gpu", "--cpus-per-task=8", "--dependency=singleton",
                  "--job-name=knuckle:/out/poses/a.txt", "--output=/out/100%%/a.log", "--ntasks=1",
                  "--wrap=exec '/bin/knuckle' 'experiment' '--step' 'poses/a.txt' --threads "
                  "\"${SLURM_CPUS_PER_TASK:-1}\""));
}

TEST(SbatchCommandTest, GivesATrainingItsWorkers) {
  ExperimentStep training = step_named("models/a.pt");
  training.is_training = true;
  EXPECT_THAT(sbatch_command(training, "/a.log", {{}, {"knuckle"}, 4}), ::testing::Contains("--ntasks=4"));
}

TEST(ShellQuotedTest, IsReadAsItWas) {
  const std::string odd = "a b'c\"$HOME`*\\";
  EXPECT_EQ(run_captured({"printf", "%s|", "", odd, "c"}).output, "|" + odd + "|c|");
}

TEST(CapturedCommandTest, HasBothOutputsAndTheStatus) {
  const CapturedCommand command = run_captured({"sh", "-c", "echo out; echo fault >&2; exit 3"});
  EXPECT_EQ(command.output, "out\nfault\n");
  EXPECT_EQ(command.status, 3);
  EXPECT_EQ(run_captured({"no_such_command_of_ours"}).status, 127);
}

TEST(JobStatesTest, TellsEndsApart) {
  const auto states = job_states("17 RUNNING\n18 COMPLETED\n19 TIMEOUT\n20_3 PENDING\n\nnonsense\n");
  EXPECT_THAT(states, ::testing::SizeIs(4));
  EXPECT_EQ(states.at("17").kind, JobState::Kind::alive);
  EXPECT_EQ(states.at("18").kind, JobState::Kind::ended);
  EXPECT_EQ(states.at("19").kind, JobState::Kind::failed);
  EXPECT_EQ(states.at("19").name, "TIMEOUT");
}

/// Commands of a Slurm that is none, in a folder that PATH names first.
class SlurmQueueTest : public ::testing::Test {
 protected:
  SlurmQueueTest() {
    for (const char* name : {"sbatch", "squeue", "scancel"}) provide(name, "exit 0");
    ::setenv("PATH", (folder_.path().string() + ":" + path_).c_str(), 1);
  }
  ~SlurmQueueTest() override { ::setenv("PATH", path_.c_str(), 1); }

  void provide(const std::string& name, const std::string& script) const {
    const std::filesystem::path file = folder_ / name;
    write_text_file(file, "#!/bin/sh\n[ \"$1\" = --version ] && exit 0\n" + script + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }

  TemporaryFolder folder_;
  std::string path_ = std::getenv("PATH");
};

TEST_F(SlurmQueueTest, SaysThatSlurmIsMissing) {
  ::setenv("PATH", "/nowhere", 1);
  EXPECT_THAT(error_of([] { SlurmQueue({}); }), HasSubstr("sbatch: not found; --slurm hands steps to Slurm"));
}

TEST_F(SlurmQueueTest, TakesTheNumberOfAJob) {
  SlurmQueue queue({{}, {"knuckle"}, 1});
  provide("sbatch", "echo 'sbatch: a warning' >&2; echo '17;cluster'");
  EXPECT_EQ(queue.submit(step_named("a"), "/a.log"), "17");
}

TEST_F(SlurmQueueTest, PassesOnWhyAJobIsRefused) {
  SlurmQueue queue({{}, {"knuckle"}, 1});
  provide("sbatch", "echo 'sbatch: error: invalid partition specified: x' >&2; exit 1");
  EXPECT_EQ(error_of([&] { queue.submit(step_named("a"), "/a.log"); }),
            "a: sbatch does not take it: invalid partition specified: x");
}

TEST_F(SlurmQueueTest, KnowsWhatItKnewWhereSlurmIsSilentForAWhile) {
  SlurmQueue queue({});
  provide("squeue", "echo 17 RUNNING");
  EXPECT_EQ(queue.states().at("17").name, "RUNNING");
  provide("squeue", "echo 'slurm_load_jobs error: Unable to contact slurm controller' >&2; exit 1");
  EXPECT_EQ(queue.states().at("17").name, "RUNNING");
  EXPECT_EQ(error_of([&] {
              for (int i = 0; i < 1000; ++i) queue.states();
            }),
            "squeue: Unable to contact slurm controller");
}

TEST_F(SlurmQueueTest, CancelsJobs) {
  SlurmQueue queue({});
  provide("scancel", "echo \"$@\" >" + (folder_ / "cancelled").string());
  queue.cancel({"17", "18"});
  EXPECT_EQ(read_text_file(folder_ / "cancelled"), "--quiet 17 18\n");
}

TEST(TrainingStarterTest, IsSrunInAJobAlone) {
  ::unsetenv("SLURM_JOB_ID");
  EXPECT_THAT(training_starter(4), IsEmpty());
  ::setenv("SLURM_JOB_ID", "17", 1);
  ::setenv("SLURM_CPUS_PER_TASK", "8", 1);
  EXPECT_THAT(training_starter(1), IsEmpty());
  EXPECT_THAT(training_starter(4),
              ElementsAre("srun", "--kill-on-bad-exit=1", "--ntasks=4", "--cpus-per-task=8"));
  ::unsetenv("SLURM_CPUS_PER_TASK");
  ::unsetenv("SLURM_JOB_ID");
}

}  // namespace
}  // namespace knuckle::testing
