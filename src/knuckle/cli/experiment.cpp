// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment.h"

#include <sstream>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"
#include "knuckle/experiment/own_program.h"
#include "knuckle/experiment/slurm_queue.h"

namespace knuckle::cli {
namespace {

constexpr int kMostJobs = 10'000;

struct ExperimentArguments {
  std::string name;
  std::string step;   ///< the only one; empty: all
  std::string slurm;  ///< options of sbatch
  bool is_by_slurm = false;
  int jobs = 8;
  ExperimentOptions options;
};

/// What a job runs, but for its step.
std::vector<std::string> command_of(const ExperimentArguments& arguments) {
  const ExperimentOptions& options = arguments.options;
  const bool is_file = arguments.name.ends_with(".toml");
  const std::string plan = is_file ? std::filesystem::absolute(arguments.name).string() : arguments.name;
  std::vector<std::string> words = {own_program_file(),
                                    "experiment",
                                    plan,
                                    "--out",
                                    std::filesystem::absolute(options.out).string(),
                                    "--scale",
                                    fmt::format("{}", options.scale),
                                    "--device",
                                    options.training.device,
                                    "--workers",
                                    fmt::format("{}", options.training.workers)};
  if (!options.models.empty()) {
    words.insert(words.end(), {"--models", std::filesystem::absolute(options.models).string()});
  }
  return words;
}

SlurmOptions slurm_options(const ExperimentArguments& arguments) {
  SlurmOptions options;
  std::istringstream words(arguments.slurm);
  for (std::string word; words >> word;) options.options.push_back(word);
  options.command = command_of(arguments);
  options.workers = arguments.options.training.workers;
  return options;
}

std::filesystem::path run_whole(const ExperimentArguments& arguments) {
  const ExperimentPlan plan = find_plan(arguments.name);
  if (!arguments.is_by_slurm) return run_experiment(plan, arguments.options);
  SlurmQueue queue(slurm_options(arguments));
  return run_experiment_as_jobs(plan, arguments.options, queue, arguments.jobs);
}

void run_step_alone(const ExperimentArguments& arguments) {
  ExperimentOptions options = arguments.options;
  options.training.starter = training_starter(options.training.workers);
  run_experiment_step(find_plan(arguments.name), options, arguments.step);
}

void run(const ExperimentArguments& arguments) {
  try {
    if (arguments.step.empty()) {
      fmt::print("report: {}\n", printable(run_whole(arguments).string()));
    } else {
      run_step_alone(arguments);
    }
  } catch (const Interrupted&) {
    throw Interrupted(fmt::format("interrupted; what was done is kept in {}, and the same command goes on",
                                  arguments.options.out.string()));
  }
}

}  // namespace

void add_experiment(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "experiment", "A whole published evaluation, from data to report; resumable",
               "knuckle experiment scia15 --scale 0.01 --out scia15");
  auto arguments = std::make_shared<ExperimentArguments>();
  verb.add_option("NAME", arguments->name, "A plan that comes with Knuckle (scia15), or a plan file (.toml)")
      ->required();
  verb.add_option("--out", arguments->options.out, "Folder for models, results and the report")->required();
  verb.add_option("--models", arguments->options.models,
                  "Folder of trained models to use instead of training");
  verb.add_option("--scale", arguments->options.scale,
                  "How much of everything: frames, sizes of models, training; (0, 1]")
      ->capture_default_str();
  verb.add_option("--device", arguments->options.training.device,
                  "Where networks are trained: cpu | cuda | cuda:N")
      ->capture_default_str();
  verb.add_option("--workers", arguments->options.training.workers,
                  "Processes that each training runs as, 1 to 1024; the models are the same for any number")
      ->check(CLI::Range(1, 1024).description(""))
      ->type_name("N")
      ->capture_default_str();
  CLI::Option* const slurm =
      verb.add_option_function<std::string>(
              "--slurm",
              [arguments](const std::string& options) {
                arguments->slurm = options;
                arguments->is_by_slurm = true;
              },
              "Do each step as a job of Slurm, with these options of sbatch: '--partition=P "
              "--cpus-per-task=8'")
          ->type_name("OPTIONS");
  verb.add_option("--jobs", arguments->jobs, "Most jobs in Slurm's queue at a time")
      ->needs(slurm)
      ->check(CLI::Range(1, kMostJobs).description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option(
          "--step", arguments->step,
          "Do this step alone, named by what it makes in the folder (models/dense.pt): what a job does")
      ->excludes(slurm)
      ->type_name("NAME");
  verb.callback([arguments] { run(*arguments); });
}

}  // namespace knuckle::cli
