// SPDX-License-Identifier: Apache-2.0
#include "knuckle/cli/verb.h"

namespace knuckle::cli {
namespace {

void add_verbs(CLI::App& program) {
  program.footer("`knuckle VERB --help` tells more about a verb, with an example.");
  add_info(program);
  add_inspect(program);
  add_shrink(program);
  add_render(program);
  add_join(program);
  add_train(program);
  add_export(program);
  add_segment(program);
  add_estimate(program);
  add_live(program);
  add_annotate(program);
  add_labels(program);
  add_record(program);
  add_cameras(program);
  add_landmarks(program);
  add_evaluate(program);
  add_experiment(program);
  add_demo(program);
}

}  // namespace
}  // namespace knuckle::cli

int main(int count, char** arguments) {
  return knuckle::cli::run_program(
      "Knuckle estimates the pose of a hand from depth images, trains the methods that do it, makes the "
      "data\n"
      "they are trained on, and measures how good they are.",
      knuckle::cli::add_verbs, count, arguments);
}
