// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "knuckle/pipeline/estimate_summary.h"
#include "knuckle/storage/growing_files.h"

namespace knuckle {

/// A run of a pipeline over a source, into files.
struct EstimateFiles {
  std::filesystem::path poses;    ///< of the surest hand; second hands go to `poses_path_of_hand(poses, 1)`
  std::filesystem::path records;  ///< frame records, one line of JSON per frame; empty: none
  std::filesystem::path summary;  ///< JSON (`write_summary`); empty: none
  std::string source_name;        ///< for messages and the summary
  Start start = Start::nearest;
  RunIdentity identity;  ///< what else the results depend on: contents of source and models, options, version
  GrowingFiles::Begin begin = GrowingFiles::Begin::anew;
  RunWarnings* warnings = nullptr;  ///< takes note of each frame of this run; null: nobody does
  /// Goes through the frames: `estimate_each`, or `track_each` of the module `track`.
  std::function<void(const FrameSource&, const Pipeline&, const RunOptions&, const TakeResult&)> run =
      [](const FrameSource& source, const Pipeline& pipeline, const RunOptions& options,
         const TakeResult& take) { estimate_each(source, pipeline, options, take); };
  /// Called when all frames are done, before the files get their names: for what is written beside them.
  std::function<void()> finish = [] {};
};

/// What a run came to.
struct EstimateRunReport {
  RunCounts counts;          ///< of all frames, those of earlier runs too
  StageDurations durations;  ///< of the frames of this run
};

/// "poses.txt" for the surest hand of a frame, "poses.hand2.txt" for the second, and so on.
std::filesystem::path poses_path_of_hand(const std::filesystem::path& poses, int hand);

/// All files of such a run, those that exist while it lasts included.
std::vector<std::filesystem::path> all_files_of(const EstimateFiles& files, int max_hands);

/// Where the journal of a run lies while the run lasts: `poses` + ".resume".
std::filesystem::path journal_path(const std::filesystem::path& poses);

/// Runs the pipeline over a source, in bounded memory, and writes each frame's results as they come, to files
/// whose names end in ".partial" until all are whole. A run that was killed or interrupted at any moment goes
/// on (`GrowingFiles::Begin::where_it_stopped`), and ends with the bytes of an undisturbed one, but for the
/// times in the summary. A frame that cannot be read is one without a hand; the summary and the report say
/// which. Shows progress.
///
/// Throws an Error where a file cannot be written, where two are the same, or where a run goes on that was
/// begun with another identity; Interrupted where the program is asked to end.
EstimateRunReport estimate_to_files(const FrameSource& source, const Pipeline& pipeline,
                                    const EstimateFiles& files);

}  // namespace knuckle
