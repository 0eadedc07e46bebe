// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "knuckle/experiment/experiment_step.h"

namespace knuckle {

/// What a queue knows of a job.
struct JobState {
  enum class Kind {
    alive,   ///< waits, runs or ends just now
    ended,   ///< came to its end, with status 0
    failed,  ///< came to another end
  };
  Kind kind = Kind::alive;
  std::string name;  ///< in the queue's own words, as in "TIMEOUT"
};

/// A scheduler that runs each job on a machine of its choice.
class JobQueue {
 public:
  virtual ~JobQueue() = default;

  /// Hands over a step, whose output is to be written to `log`; the job's number. A job of the same step that
  /// is in the queue already comes first.
  virtual std::string submit(const ExperimentStep& step, const std::filesystem::path& log) = 0;
  /// The jobs that the queue knows, by number. One that ended a while ago may be missing.
  virtual std::map<std::string, JobState> states() = 0;
  virtual void cancel(const std::vector<std::string>& jobs) = 0;
};

/// How steps are run as jobs.
struct StepJobsOptions {
  int most = 8;                                ///< jobs in the queue at the same time, [1, 10000]
  std::filesystem::path logs;                  ///< folder of the jobs' logs
  std::chrono::milliseconds look_every{500};   ///< time between looks at what is done
  std::chrono::milliseconds ask_every{5000};   ///< time between questions to the queue
  std::chrono::milliseconds patience{60'000};  ///< for what another machine has written to be seen here
};

/// Does all steps, those that are not copies as jobs: each as soon as what it needs is done. Whether a step
/// is done is seen from its files (`is_step_done`), so it does not matter who did it. Throws an Error in the
/// words of the job where one fails, with the place of its log; then, and where the program is asked to end,
/// the other jobs are cancelled.
void run_as_jobs(const std::vector<ExperimentStep>& steps, JobQueue& queue, const StepJobsOptions& options);

}  // namespace knuckle
