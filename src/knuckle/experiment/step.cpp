// SPDX-License-Identifier: Apache-2.0
#include "knuckle/experiment/step.h"

#include "knuckle/core/text_file.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

bool holds(const std::filesystem::path& record, const Inputs& inputs) {
  return std::filesystem::exists(record) && read_text_file(record) == inputs.text();
}

}  // namespace

StepOutcome run_step(const std::filesystem::path& output, const Inputs& inputs,
                     const std::function<void(StepStart)>& work) {
  const std::filesystem::path made_from = output.string() + ".inputs";
  const std::filesystem::path begun = output.string() + ".begun";
  if (std::filesystem::exists(output) && holds(made_from, inputs)) return StepOutcome::kept;
  const StepStart start = holds(begun, inputs) ? StepStart::again : StepStart::anew;
  make_folder(output.parent_path());
  write_text_file(begun, inputs.text());
  // This record goes before the work: a run that is stopped in it leaves an output of unknown inputs.
  std::filesystem::remove(made_from);
  work(start);
  write_text_file(made_from, inputs.text());
  std::filesystem::remove(begun);
  return StepOutcome::done;
}

}  // namespace knuckle
