// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step_jobs.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string_view>
#include <thread>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using Clock = std::chrono::steady_clock;

/// A step in the queue.
struct StepJob {
  const ExperimentStep* step;
  Inputs inputs;
  std::string number;
  std::filesystem::path log;
  std::optional<Clock::time_point> ended = std::nullopt;  ///< when the queue said so
};

/// The last error line of a log, without the program's name; empty where there is none.
std::string fault_in(const std::filesystem::path& log) {
  constexpr std::string_view kPrefix = "knuckle: ";
  std::string fault;
  if (!std::filesystem::exists(log)) return fault;
  for (const std::string& line : read_lines(log)) {
    if (line.starts_with(kPrefix)) fault = trimmed(std::string_view(line).substr(kPrefix.size()));
  }
  return fault;
}

class StepJobs {
 public:
  StepJobs(const std::vector<ExperimentStep>& steps, JobQueue& queue, const StepJobsOptions& options)
      : queue_(queue), options_(options) {
    for (const ExperimentStep& step : steps) waiting_.push_back(&step);
  }

  void run() {
    make_folder(options_.logs);
    try {
      for (begin_all(); !running_.empty(); begin_all()) {
        std::this_thread::sleep_for(options_.look_every);
        end_if_interrupted();
        look();
      }
    } catch (...) {
      cancel_all();
      throw;
    }
  }

 private:
  /// Begins all steps that can begin. Those that are done already make room for others at once.
  void begin_all() {
    while (begin_one()) {
    }
  }

  bool begin_one() {
    const auto ready = std::ranges::find_if(waiting_, [&](const ExperimentStep* step) {
      return std::ranges::all_of(step->needs, [&](const std::string& need) { return done_.contains(need); });
    });
    if (ready == waiting_.end() || std::ssize(running_) >= options_.most) return false;
    const ExperimentStep& step = **ready;
    waiting_.erase(ready);
    begin(step);
    return true;
  }

  void begin(const ExperimentStep& step) {
    if (step.is_copy) {
      run_here(step);
      done_.insert(step.name);
      return;
    }
    const Inputs inputs = step.inputs();
    if (is_step_done(step.output, inputs)) {
      finish(step);
      return;
    }
    std::string name = step.name;
    std::ranges::replace(name, '/', '_');
    const std::filesystem::path log = options_.logs / (name + ".log");
    running_.push_back({&step, inputs, queue_.submit(step, log), log});
    fmt::print("{}: job {}\n", step.title, running_.back().number);
    std::fflush(stdout);
  }

  void finish(const ExperimentStep& step) {
    step.tidy();
    done_.insert(step.name);
  }

  void look() {
    std::erase_if(running_, [&](const StepJob& job) {
      const bool is_done = is_step_done(job.step->output, job.inputs);
      if (is_done) finish(*job.step);
      return is_done;
    });
    if (running_.empty() || Clock::now() - asked_ < options_.ask_every) return;
    asked_ = Clock::now();
    const std::map<std::string, JobState> states = queue_.states();
    for (StepJob& job : running_) {
      const auto found = states.find(job.number);
      judge(job, found == states.end() ? JobState{JobState::Kind::ended, {}} : found->second);
    }
  }

  /// Throws where a job has come to an end without doing its step.
  void judge(StepJob& job, const JobState& state) const {
    if (state.kind == JobState::Kind::alive || is_step_done(job.step->output, job.inputs)) return;
    if (state.kind == JobState::Kind::failed) fail_for(job, fmt::format("failed ({})", state.name));
    if (!job.ended) job.ended = Clock::now();
    if (Clock::now() - *job.ended >= options_.patience) {
      fail_for(job, "has ended, but what it makes is not here: expected a folder that all machines see");
    }
  }

  [[noreturn]] static void fail_for(const StepJob& job, std::string_view what) {
    const std::string fault = fault_in(job.log);
    fail("{}: job {} {}{}{}; its log is {}", job.step->name, job.number, what, fault.empty() ? "" : ": ",
         fault, job.log.string());
  }

  void cancel_all() const {
    std::vector<std::string> numbers;
    for (const StepJob& job : running_) numbers.push_back(job.number);
    if (!numbers.empty()) queue_.cancel(numbers);
  }

  JobQueue& queue_;
  const StepJobsOptions& options_;
  std::vector<const ExperimentStep*> waiting_;
  std::vector<StepJob> running_;
  std::set<std::string> done_;
  Clock::time_point asked_ = Clock::now();
};

}  // namespace

void run_as_jobs(const std::vector<ExperimentStep>& steps, JobQueue& queue, const StepJobsOptions& options) {
  StepJobs(steps, queue, options).run();
}

}  // namespace knuckle
