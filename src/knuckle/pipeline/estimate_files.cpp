// SPDX-License-Identifier: Apache-2.0
#include "knuckle/pipeline/estimate_files.h"

#include <cerrno>
#include <fstream>
#include <map>
#include <system_error>
#include <utility>

#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/progress.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/pipeline/estimate_all.h"
#include "knuckle/pipeline/record_of.h"
#include "knuckle/storage/file_io.h"

namespace fs = std::filesystem;

namespace knuckle {
namespace {

/// Files with what they are, for messages.
using NamedFiles = std::vector<std::pair<fs::path, std::string>>;

std::vector<fs::path> poses_paths(const fs::path& poses, int hands) {
  std::vector<fs::path> paths;
  for (int hand = 0; hand < hands; ++hand) paths.push_back(poses_path_of_hand(poses, hand));
  return paths;
}

NamedFiles outputs_of(const EstimateFiles& files, int hands) {
  NamedFiles outputs;
  for (const fs::path& path : poses_paths(files.poses, hands)) outputs.emplace_back(path, "poses");
  if (!files.records.empty()) outputs.emplace_back(files.records, "records");
  if (!files.summary.empty()) outputs.emplace_back(files.summary, "the summary");
  return outputs;
}

/// Also under the names that files have while the run lasts.
NamedFiles all_outputs_of(const EstimateFiles& files, int hands) {
  NamedFiles all = outputs_of(files, hands);
  for (const auto& [path, what] : outputs_of(files, hands)) all.emplace_back(partial_path(path), what);
  all.emplace_back(journal_path(files.poses), "the journal");
  all.emplace_back(files.poses.string() + ".options.toml", "the options");
  return all;
}

void require_distinct(const EstimateFiles& files, int hands) {
  std::map<fs::path, std::string> seen;
  for (const auto& [path, what] : all_outputs_of(files, hands)) {
    const auto [place, is_new] = seen.emplace(fs::weakly_canonical(fs::absolute(path)), what);
    if (!is_new) {
      fail("{}: is the file for {} and for {}, expected a file for each", path.string(), place->second, what);
    }
  }
}

std::vector<GrowingFile> growing_files(const EstimateFiles& files, const Pipeline& pipeline) {
  std::vector<GrowingFile> growing;
  for (const fs::path& path : poses_paths(files.poses, pipeline.hand().max_hands)) {
    growing.push_back({path, poses_head(pipeline.convention())});
  }
  if (!files.records.empty()) growing.push_back({files.records, {}});
  return growing;
}

/// All that the results of a run depend on.
RunIdentity identity_of(const EstimateFiles& files, const FrameSource& source, const Pipeline& pipeline) {
  RunIdentity identity = files.identity;
  identity.emplace_back("number of frames", fmt::format("{}", source.size()));
  identity.emplace_back("convention", pipeline.convention().name);
  identity.emplace_back("pixel origin", source.pixel_origin() == PixelOrigin::corner ? "corner" : "centre");
  identity.emplace_back("start", kStartNames[static_cast<std::size_t>(files.start)]);
  identity.emplace_back("number of hands", fmt::format("{}", pipeline.hand().max_hands));
  identity.emplace_back("file for records",
                        files.records.empty() ? "none" : fs::weakly_canonical(files.records).string());
  return identity;
}

void write_summary_file(const EstimateFiles& files, const Pipeline& pipeline, const StageDurations& durations,
                        const VisitNotes& notes) {
  write_file_atomically(files.summary, [&](const fs::path& temporary) {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary);
    write_summary(out, {files.source_name, std::string(pipeline.convention().name)}, durations, notes);
    out.close();
    if (!out) fail("{}: cannot write: {}", files.summary.string(), std::generic_category().message(errno));
  });
}

/// The pieces of a frame's results, one per growing file.
std::vector<std::string> pieces_of(const FrameResult& result, const EstimateFiles& files,
                                   const Pipeline& pipeline, PixelOrigin origin) {
  std::vector<std::string> pieces;
  for (int hand = 0; hand < pipeline.hand().max_hands; ++hand) {
    pieces.push_back(pose_line(pose_of(result.estimate, pipeline.convention(), hand), origin));
  }
  if (!files.records.empty()) pieces.push_back(to_json_line(record_of(result, origin)) + "\n");
  return pieces;
}

}  // namespace

fs::path poses_path_of_hand(const fs::path& poses, int hand) {
  if (hand == 0) return poses;
  return poses.parent_path() /
         fmt::format("{}.hand{}{}", poses.stem().string(), hand + 1, poses.extension().string());
}

std::vector<fs::path> all_files_of(const EstimateFiles& files, int max_hands) {
  std::vector<fs::path> paths;
  for (const auto& [path, what] : all_outputs_of(files, max_hands)) paths.push_back(path);
  return paths;
}

fs::path journal_path(const fs::path& poses) {
  return poses.string() + ".resume";
}

EstimateRunReport estimate_to_files(const FrameSource& source, const Pipeline& pipeline,
                                    const EstimateFiles& files) {
  require_start(source, files.start, files.source_name);
  require_distinct(files, pipeline.hand().max_hands);
  for (const auto& [path, what] : outputs_of(files, pipeline.hand().max_hands)) check_writable(path);
  GrowingFiles growing(journal_path(files.poses), growing_files(files, pipeline),
                       identity_of(files, source, pipeline), files.begin);
  EstimateRunReport report;
  const PixelOrigin origin = source.pixel_origin();
  try {
    Progress progress("estimate", "frames", source.size(), growing.size());
    const RunOptions options{.start = files.start, .first = growing.size(), .warnings = files.warnings};
    files.run(source, pipeline, options, [&](const FrameResult& result) {
      growing.append(pieces_of(result, files, pipeline, origin),
                     note_as_line(note_of(result.estimate, result.fault)));
      if (result.fault.empty()) report.durations.add(result.estimate.times);
      progress.advance();
    });
  } catch (const Interrupted&) {
    throw Interrupted(fmt::format("interrupted after {} of {} frames; continue with --resume", growing.size(),
                                  source.size()));
  }
  const VisitNotes notes = [&](const std::function<void(const FrameNote&)>& visit) {
    growing.for_each_note([&](std::string_view line) { visit(note_from_line(line)); });
  };
  report.counts = counts_of(notes);
  if (!files.summary.empty()) write_summary_file(files, pipeline, report.durations, notes);
  files.finish();
  growing.publish();
  return report;
}

}  // namespace knuckle
