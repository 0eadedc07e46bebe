// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step.h"

#include <fmt/format.h>

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/work_claim.h"

namespace knuckle {
namespace {

bool holds(const std::filesystem::path& record, const Inputs& inputs) {
  return std::filesystem::exists(record) && read_text_file(record) == inputs.text();
}

std::filesystem::path made_from(const std::filesystem::path& output) {
  return output.string() + ".inputs";
}

}  // namespace

bool is_step_done(const std::filesystem::path& output, const Inputs& inputs) {
  return std::filesystem::exists(output) && holds(made_from(output), inputs);
}

StepOutcome run_step(const std::filesystem::path& output, const Inputs& inputs,
                     const std::function<void(StepStart)>& work) {
  if (is_step_done(output, inputs)) return StepOutcome::kept;
  make_folder(output.parent_path());
  const WorkClaim claim(output.string() + ".claim", [&] {
    fmt::print("{}: waiting for another process, which makes it\n", output.string());
  });
  if (is_step_done(output, inputs)) return StepOutcome::kept;  // by the process that we waited for
  const std::filesystem::path begun = output.string() + ".begun";
  const StepStart start = holds(begun, inputs) ? StepStart::again : StepStart::anew;
  write_text_file(begun, inputs.text());
  // This record goes before the work: a run that is stopped in it leaves an output of unknown inputs.
  std::filesystem::remove(made_from(output));
  work(start);
  write_text_file(made_from(output), inputs.text());
  std::filesystem::remove(begun);
  return StepOutcome::done;
}

}  // namespace knuckle
