// SPDX-License-Identifier: Apache-2.0
// Texts: options, labels, results, and what a user types.
#include "fuzz_target.h"

#include <stdexcept>
#include <string>
#include <vector>

#include "knuckle/core/error.h"
#include "knuckle/core/options.h"
#include "knuckle/core/text.h"
#include "knuckle/data/boxes_file.h"
#include "knuckle/data/frame_record.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/data/readers/folder_format.h"
#include "knuckle/data/readers/icg_format.h"
#include "knuckle/data/readers/line_index.h"
#include "knuckle/data/source_spec.h"
#include "knuckle/pipeline/frame_note.h"
#include "knuckle/storage/growing_files.h"
#include "knuckle/synth/manifest.h"

namespace knuckle::fuzz {

void run_lines(Bytes bytes) {
  const FuzzFile file(bytes, ".txt");
  const LineIndex lines(file.path());
  for (std::int64_t i = 0; i < lines.size(); ++i) (void)lines.line(i);
}

void run_toml(Bytes bytes) {
  const OptionTable document = OptionTable::parse(as_text(bytes), "fuzz.toml");
  (void)document.table("hand").text_or("side", "auto");
  (void)document.tables("refine");
  document.finish();
}

void run_dataset_toml(Bytes bytes) {
  const FuzzFile file(bytes, ".toml");
  (void)read_folder_description(file.path());
}

void run_manifest(Bytes bytes) {
  const FuzzFile file(bytes, ".toml");
  (void)load_manifest(file.path());
}

void run_numbers(Bytes bytes) {
  const std::string shown = printable(as_text(bytes));
  for (const char c : shown) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) throw std::logic_error("not printable");
  }
  if (printable(shown) != shown) throw std::logic_error("printable text is not shown as it is");
  (void)parse_numbers(as_text(bytes), "fuzz");
}

void run_poses(Bytes bytes) {
  const FuzzFile file(bytes, ".txt");
  (void)read_poses_file(file.path());
}

void run_boxes(Bytes bytes) {
  const FuzzFile file(bytes, ".csv");
  (void)read_boxes_file(file.path());
}

void run_record(Bytes bytes) {
  (void)parse_frame_record(as_text(bytes));
}

void run_source(Bytes bytes) {
  (void)parse_source_spec(as_text(bytes));
}

void run_calibration(Bytes bytes) {
  const FuzzFile file(bytes, ".txt");
  (void)read_icg_calibration(file.path());
}

/// A run that was killed goes on from its journal, whatever stands in it.
void run_journal(Bytes bytes) {
  const FuzzFile journal(bytes, ".journal");
  const FuzzFolder folder;
  const std::filesystem::path result = folder.path() / "result.txt";
  folder.write(partial_path(result).filename(), "# head\n1 2 3\n4 5 6\n");
  GrowingFiles files(journal.path(), {{result, "# head\n"}}, {{"source", "fuzz"}},
                     GrowingFiles::Begin::where_it_stopped);
  files.for_each_note([](std::string_view note) { (void)note_from_line(note); });
}

}  // namespace knuckle::fuzz
