// SPDX-License-Identifier: Apache-2.0
#include <atomic>

#include <fmt/format.h>

#include "knuckle/cli/finished_part.h"
#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/interruption.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/shard.h"
#include "knuckle/core/text.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/data/writers/frame_writer.h"
#include "knuckle/eval/pictures/contact_sheet.h"
#include "knuckle/synth/generator_version.h"
#include "knuckle/synth/manifest.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle::cli {
namespace {

struct RenderArguments {
  std::filesystem::path manifest;
  std::filesystem::path out;
  std::string format = "h5";
  std::int64_t first = 0;
  std::int64_t count = 0;
  std::string shard;  ///< empty: all frames
  std::filesystem::path sheet;
  int tiles = 48;
  ContactSheetOptions layout;
};

/// How many frames to render: what was asked for, or all from the first on.
std::int64_t frames_to_render(const RenderArguments& arguments, std::int64_t available) {
  if (arguments.first + std::max<std::int64_t>(arguments.count, 1) > available) {
    fail("{}: frames {} to {} were asked for, it has {}", arguments.manifest.string(), arguments.first,
         arguments.first + arguments.count, available);
  }
  return arguments.count > 0 ? arguments.count : available - arguments.first;
}

/// All frames, or the part that one of many machines makes.
IndexRange frames_of_shard(const RenderArguments& arguments, const IndexRange& whole) {
  if (arguments.shard.empty()) return whole;
  if (arguments.format != "h5")
    fail("--shard: parts are joined as h5; expected --format h5, not {}", printable(arguments.format));
  return part_of(whole, shard_from_text(arguments.shard));
}

void write_contact_sheet(const RenderArguments& arguments, const FrameSource& source,
                         const IndexRange& rendered) {
  const auto frames = spread_frames(rendered.first, rendered.count, arguments.tiles);
  write_png(arguments.sheet, contact_sheet(source, frames, arguments.layout));
  fmt::print("contact sheet of {} frames: {}\n", frames.size(), printable(arguments.sheet.string()));
}

/// A file of frames goes on; folders are written again.
std::string interruption_of(const RenderArguments& arguments, std::int64_t done, std::int64_t count) {
  return fmt::format("interrupted after {} of {} frames{}", done, count,
                     arguments.format == "h5" ? "; the same command goes on" : "");
}

FrameWriterOptions writer_options(const RenderArguments& arguments, const IndexRange& whole,
                                  const IndexRange& frames) {
  FrameWriterOptions options;
  options.first = frames.first;
  options.count = frames.count;
  options.manifest = read_text_file(arguments.manifest);
  options.generator = fmt::format("knuckle {}, generator {}", KNUCKLE_VERSION, kGeneratorVersion);
  if (!arguments.shard.empty()) options.part_of = whole;
  return options;
}

void write_set(const RenderArguments& arguments, const FrameSource& source,
               const FrameWriterOptions& options) {
  const std::int64_t count = options.count;
  const auto writer = create_frame_writer(arguments.format, arguments.out, options);
  Progress progress("render", "frames", count);
  std::atomic<std::int64_t> done = 0;
  try {
    parallel_for(count, [&](std::int64_t i) {
      const std::int64_t index = options.first + i;
      if (!writer->has(index)) writer->write(index, source.read(index));
      ++done;
      progress.advance();
    });
  } catch (const Interrupted&) {
    throw Interrupted(interruption_of(arguments, done, count));
  }
  writer->finish();
}

void write_frames(const RenderArguments& arguments, const FrameSource& source,
                  const FrameWriterOptions& options) {
  const bool was_there = is_part_finished(arguments.out, options);
  if (!was_there) write_set(arguments, source, options);
  // Also beside a part that was there: the run that made it may have been stopped before it wrote them.
  write_resolved_options(arguments.out, load_manifest(arguments.manifest).resolved);
  fmt::print("{} frames: {}{}\n", options.count, printable(arguments.out.string()),
             was_there ? " (was there, and is whole)" : "");
}

void run_render(const RenderArguments& arguments) {
  if (arguments.out.empty() && arguments.sheet.empty()) throw CLI::RequiredError("--out or --contact-sheet");
  const auto source = open_synthetic(arguments.manifest);
  const IndexRange whole{arguments.first, frames_to_render(arguments, source->size())};
  const IndexRange frames = frames_of_shard(arguments, whole);
  if (!arguments.out.empty()) write_frames(arguments, *source, writer_options(arguments, whole, frames));
  if (!arguments.sheet.empty()) write_contact_sheet(arguments, *source, frames);
}

}  // namespace

void add_render(CLI::App& program) {
  CLI::App& verb = add_verb(program, "render", "Make labelled synthetic frames from a manifest",
                            "knuckle render --manifest manifests/demo.toml --out demo.h5\n"
                            "  knuckle render --manifest manifests/demo.toml --contact-sheet demo.png");
  auto arguments = std::make_shared<RenderArguments>();
  verb.add_option("--manifest", arguments->manifest, "What to render (manifests/)")
      ->type_name("FILE")
      ->required();
  verb.add_option("--out", arguments->out,
                  "File (h5) or folder (folder, icg) to write; h5 goes on where a run was stopped")
      ->type_name("PATH");
  verb.add_option("--contact-sheet", arguments->sheet,
                  "PNG with small pictures of the frames; alone, or beside --out")
      ->type_name("FILE");
  verb.add_option("--tiles", arguments->tiles, "Pictures on the contact sheet, spread evenly over the frames")
      ->check(CLI::Range(1, 10000).description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--columns", arguments->layout.columns, "Pictures in a row of the contact sheet")
      ->check(CLI::Range(1, 100).description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--format", arguments->format, "h5 | folder | icg")
      ->type_name("NAME")
      ->capture_default_str();
  verb.add_option("--first", arguments->first, "Number of the first frame")
      ->check(CLI::NonNegativeNumber.description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option("--count", arguments->count, "Number of frames; 0: all from the first on")
      ->check(CLI::NonNegativeNumber.description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.add_option(
          "--shard", arguments->shard,
          "The I-th (from 0) of N parts alone, for `knuckle join`; auto: that of the task of a Slurm array "
          "0-(N-1)")
      ->type_name("I/N");
  verb.callback([arguments] { run_render(*arguments); });
}

}  // namespace knuckle::cli
