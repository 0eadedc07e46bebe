// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "knuckle/experiment/step_jobs.h"

namespace knuckle {

/// How steps become jobs of Slurm.
struct SlurmOptions {
  std::vector<std::string> options;  ///< of sbatch, as in {"--partition=gpu", "--cpus-per-task=8"}
  /// The program and what it is told, but for the step: {"knuckle", "experiment", "scia15", "--out", ...}.
  std::vector<std::string> command;
  int workers = 1;  ///< tasks of a job that trains
};

/// The words that hand a step to Slurm. The job is named by the step's output; of jobs with one name Slurm
/// runs one at a time, so a step that a run of the experiment which was killed has left in the queue is
/// waited for. The job uses as many threads as `--cpus-per-task` gives it.
std::vector<std::string> sbatch_command(const ExperimentStep& step, const std::filesystem::path& log,
                                        const SlurmOptions& options);

/// What `squeue --format='%i %T'` says, a job per line.
std::map<std::string, JobState> job_states(std::string_view squeue);

/// Slurm by its commands sbatch, squeue and scancel.
class SlurmQueue final : public JobQueue {
 public:
  /// Throws an Error where these commands are missing.
  explicit SlurmQueue(SlurmOptions options);

  std::string submit(const ExperimentStep& step, const std::filesystem::path& log) override;
  /// Where Slurm does not answer, no more than what it said last; an Error once that has gone on for minutes.
  std::map<std::string, JobState> states() override;
  void cancel(const std::vector<std::string>& jobs) override;

 private:
  SlurmOptions options_;
  std::map<std::string, JobState> known_;
  int silences_ = 0;
};

/// What starts the processes of a training inside a job: srun, told of the job's cores. Empty where this is
/// no job or one process will do.
std::vector<std::string> training_starter(int workers);

}  // namespace knuckle
