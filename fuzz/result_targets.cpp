// SPDX-License-Identifier: Apache-2.0
// What runs leave for later ones: notes of frames, summaries, and records of trainings.
#include "fuzz_target.h"

#include <stdexcept>

#include "knuckle/core/error.h"
#include "knuckle/experiment/layout.h"
#include "knuckle/experiment/run_summary.h"
#include "knuckle/experiment/training_record.h"
#include "knuckle/pipeline/frame_note.h"

namespace knuckle::fuzz {

/// A line of the journal of `estimate`. What is read is written as a line that is read as the same.
void run_frame_note(Bytes bytes) {
  const std::string line = note_as_line(note_from_line(as_text(bytes)));
  if (note_as_line(note_from_line(line)) != line)
    throw std::logic_error("a note is not read as it was written");
}

/// '0': the summary of a segmentation; '1': of an estimation; '2': how a model came to be; '3': the metrics
/// of its training.
void run_experiment_results(Bytes bytes) {
  static const FuzzFolder folder;
  const auto [which, content] = selected(bytes, 4);
  const std::filesystem::path model = folder.path() / (which == 3 ? "trained.pt" : "given.pt");
  const std::filesystem::path summary = folder.path() / "summary.json";
  if (which < 2) {
    folder.write(summary, as_text(content));
    which == 0 ? (void)read_segmentation_summary(summary) : (void)read_inference_ms(summary);
    return;
  }
  folder.write(ExperimentFolder::training_record(model), which == 2 ? as_text(content) : "{\"seconds\": 2}");
  if (which == 3) folder.write(ExperimentFolder::metrics(model), as_text(content));
  (void)read_training_record(model);
}

}  // namespace knuckle::fuzz
