// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/segment_all.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/storage/growing_files.h"

namespace knuckle::cli {
namespace {

struct SegmentArguments {
  std::string source;
  std::filesystem::path pipeline = resource_path("pipelines/default.toml");
  std::filesystem::path out;
  std::filesystem::path json;
  std::string init = "nearest";
};

/// Where it is interrupted, the frames that are done are kept beside the output.
std::vector<FrameSegmentation> segment_until_interrupted(const SegmentArguments& arguments,
                                                         const FrameSource& source,
                                                         const HandFinder& finder) {
  std::vector<FrameSegmentation> frames;
  try {
    Progress progress("segment", "frames", source.size());
    segment_each(source, finder, start_from_name(arguments.init), arguments.source,
                 [&](const FrameSegmentation& frame) {
                   frames.push_back(frame);
                   progress.advance();
                 });
  } catch (const Interrupted&) {
    const std::filesystem::path kept = partial_path(arguments.out);
    write_text_file(kept, boxes_csv(frames));
    throw Interrupted(fmt::format("interrupted after {} of {} frames, kept in {}", frames.size(),
                                  source.size(), kept.string()));
  }
  return frames;
}

void run_segment(const SegmentArguments& arguments) {
  check_writable(arguments.out);
  if (!arguments.json.empty()) check_writable(arguments.json);
  const auto source = open_source(arguments.source);
  const HandFinder finder = HandFinder::load(arguments.pipeline);
  const std::vector<FrameSegmentation> frames = segment_until_interrupted(arguments, *source, finder);
  write_text_file(arguments.out, boxes_csv(frames));
  if (!arguments.json.empty()) write_text_file(arguments.json, summary_json(frames, arguments.source));
  write_resolved_options(arguments.out, finder.resolved_options());
  const auto found = std::ranges::count_if(frames, &FrameSegmentation::found);
  fmt::print("{} frames, hand found in {}: {}\n", frames.size(), found, printable(arguments.out.string()));
}

}  // namespace

void add_segment(CLI::App& program) {
  CLI::App& verb = add_verb(program, "segment", "Find the hand in every frame of a source",
                            "knuckle segment --source synthetic:manifests/demo.toml --out boxes.csv");
  auto arguments = std::make_shared<SegmentArguments>();
  add_source_option(verb, arguments->source);
  verb.add_option("--pipeline", arguments->pipeline, "Pipeline file; its [hand] and [segmentation] count")
      ->type_name("FILE")
      ->capture_default_str();
  verb.add_option("--out", arguments->out, "CSV: frame,found,x,y,width,height,milliseconds")
      ->type_name("FILE")
      ->required();
  verb.add_option("--json", arguments->json,
                  "Summary as JSON: times, and the overlap of masks where the source has true ones")
      ->type_name("FILE");
  add_init_option(verb, arguments->init);
  verb.callback([arguments] { run_segment(*arguments); });
}

}  // namespace knuckle::cli
