// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <exception>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

int run(int count, char** arguments) {
  using namespace knuckle::cli;
  CLI::App program(
      "Knuckle estimates the pose of a hand from depth images, trains the methods that do it, makes the "
      "data\n"
      "they are trained on, and measures how good they are.");
  program.name("knuckle");
  program.require_subcommand(1);
  program.footer("`knuckle VERB --help` tells more about a verb, with an example.");
  remember_command_line(count, arguments);
  add_info(program);
  add_inspect(program);
  add_shrink(program);
  add_render(program);
  add_train(program);
  add_segment(program);
  add_estimate(program);
  add_evaluate(program);
  add_experiment(program);
  add_demo(program);
  try {
    program.parse(count, arguments);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : kWrongUsage;
  }
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  try {
    return run(count, arguments);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "knuckle: there is not enough memory\n");
  } catch (const std::exception& error) {
    fmt::print(stderr, "knuckle: {}\n", error.what());
  }
  return kFailed;
}
