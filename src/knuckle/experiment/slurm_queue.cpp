// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/slurm_queue.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <utility>

#include <fmt/format.h>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"
#include "knuckle/experiment/captured_command.h"

namespace knuckle {
namespace {

constexpr int kMostSilences = 60;  // of 5 s each: a controller that is started again answers by then

/// In the name of a log, % begins what Slurm replaces.
std::string as_log_name(const std::filesystem::path& log) {
  std::string name;
  for (const char character : std::filesystem::absolute(log).string()) {
    name += character;
    if (character == '%') name += '%';
  }
  return name;
}

/// The last line that a command of Slurm said, without its own name for it.
std::string complaint_of(const CapturedCommand& command) {
  std::string complaint = "no reason given";
  for (const std::string_view line : split(command.output, '\n')) {
    if (!trimmed(line).empty()) complaint = trimmed(line);
  }
  for (const std::string_view prefix : {"sbatch: error: ", "squeue: error: ", "slurm_load_jobs error: "}) {
    if (complaint.starts_with(prefix)) complaint.erase(0, prefix.size());
  }
  return complaint;
}

JobState state_named(std::string_view name) {
  constexpr std::array<std::string_view, 10> kFailures = {
      "BOOT_FAIL", "CANCELLED",     "DEADLINE",  "FAILED",  "LAUNCH_FAILED",
      "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED", "TIMEOUT"};
  if (name == "COMPLETED") return {JobState::Kind::ended, std::string(name)};
  const bool is_failure = std::ranges::find(kFailures, name) != kFailures.end();
  return {is_failure ? JobState::Kind::failed : JobState::Kind::alive, std::string(name)};
}

}  // namespace

std::vector<std::string> sbatch_command(const ExperimentStep& step, const std::filesystem::path& log,
                                        const SlurmOptions& options) {
  std::vector<std::string> command = options.command;
  command.insert(command.end(), {"--step", step.name});
  std::vector<std::string> words = {"sbatch", "--parsable"};
  words.insert(words.end(), options.options.begin(), options.options.end());
  words.insert(
      words.end(),
      {"--dependency=singleton", "--job-name=knuckle:" + std::filesystem::absolute(step.output).string(),
       "--output=" + as_log_name(log), fmt::format("--ntasks={}", step.is_training ? options.workers : 1),
       fmt::format("--wrap=exec {} --threads \"${{SLURM_CPUS_PER_TASK:-1}}\"", shell_quoted(command))});
  return words;
}

std::map<std::string, JobState> job_states(std::string_view squeue) {
  std::map<std::string, JobState> states;
  for (const std::string_view line : split(squeue, '\n')) {
    const std::vector<std::string_view> parts = split(trimmed(line), ' ');
    if (parts.size() == 2) states[std::string(parts[0])] = state_named(parts[1]);
  }
  return states;
}

SlurmQueue::SlurmQueue(SlurmOptions options) : options_(std::move(options)) {
  for (const char* command : {"sbatch", "squeue", "scancel"}) {
    if (run_captured({command, "--version"}).status != 0) {
      fail(
          "{}: not found; --slurm hands steps to Slurm by its commands (Debian: apt-get install "
          "slurm-client); "
          "without it they are done on this machine",
          command);
    }
  }
}

std::string SlurmQueue::submit(const ExperimentStep& step, const std::filesystem::path& log) {
  const CapturedCommand answer = run_captured(sbatch_command(step, log, options_));
  end_if_interrupted();
  if (answer.status != 0) fail("{}: sbatch does not take it: {}", step.name, complaint_of(answer));
  // "17", or "17;cluster"; warnings may stand before it.
  const std::vector<std::string_view> lines = split(trimmed(answer.output), '\n');
  std::string number(trimmed(split(lines.back(), ';').front()));
  known_[number] = {JobState::Kind::alive, "PENDING"};
  return number;
}

std::map<std::string, JobState> SlurmQueue::states() {
  const CapturedCommand answer =
      run_captured({"squeue", "--me", "--states=all", "--noheader", "--format=%i %T"});
  if (answer.status == 0) {
    silences_ = 0;
    known_ = job_states(answer.output);
  } else if (++silences_ >= kMostSilences) {
    fail("squeue: {}", complaint_of(answer));
  }
  return known_;
}

void SlurmQueue::cancel(const std::vector<std::string>& jobs) {
  std::vector<std::string> words = {"scancel", "--quiet"};
  words.insert(words.end(), jobs.begin(), jobs.end());
  run_captured(words);
}

std::vector<std::string> training_starter(int workers) {
  if (workers <= 1 || std::getenv("SLURM_JOB_ID") == nullptr) return {};
  std::vector<std::string> words = {"srun", "--kill-on-bad-exit=1", fmt::format("--ntasks={}", workers)};
  // Since Slurm 22.05 srun does not take the cores over from sbatch.
  const char* const cores = std::getenv("SLURM_CPUS_PER_TASK");
  if (cores != nullptr) words.push_back(fmt::format("--cpus-per-task={}", cores));
  return words;
}

}  // namespace knuckle
