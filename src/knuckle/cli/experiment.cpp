// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/experiment.h"

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/text.h"

namespace knuckle::cli {
namespace {

struct ExperimentArguments {
  std::string name;
  ExperimentOptions options;
};

void run(const ExperimentArguments& arguments) {
  try {
    const std::filesystem::path page = run_experiment(find_plan(arguments.name), arguments.options);
    fmt::print("report: {}\n", printable(page.string()));
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
  verb.add_option("--device", arguments->options.training.device, "Where networks are trained: cpu | cuda")
      ->capture_default_str();
  verb.callback([arguments] { run(*arguments); });
}

}  // namespace knuckle::cli
