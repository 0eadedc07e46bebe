// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/file_io.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/progress.h"
#include "knuckle/data/frame_writer.h"
#include "knuckle/synth/synthetic_source.h"

namespace knuckle::cli {
namespace {

struct RenderArguments {
  std::filesystem::path manifest;
  std::filesystem::path out;
  std::string format = "h5";
  std::int64_t first = 0;
  std::int64_t count = 0;
};

/// How many frames to render: what was asked for, or all from the first on.
std::int64_t frames_to_render(const RenderArguments& arguments, std::int64_t available) {
  if (arguments.first + std::max<std::int64_t>(arguments.count, 1) > available) {
    fail("{}: frames {} to {} were asked for, it has {}", arguments.manifest.string(), arguments.first,
         arguments.first + arguments.count, available);
  }
  return arguments.count > 0 ? arguments.count : available - arguments.first;
}

void run_render(const RenderArguments& arguments) {
  const auto source = open_synthetic(arguments.manifest);
  const std::int64_t count = frames_to_render(arguments, source->size());
  FrameWriterOptions options;
  options.first = arguments.first;
  options.count = count;
  options.manifest = read_text_file(arguments.manifest);
  const auto writer = create_frame_writer(arguments.format, arguments.out, options);
  Progress progress("render", "frames", count);
  parallel_for(count, [&](std::int64_t i) {
    const std::int64_t index = arguments.first + i;
    if (!writer->has(index)) writer->write(index, source->read(index));
    progress.advance();
  });
  writer->finish();
  write_resolved_options(arguments.out, options.manifest);
  fmt::print("{} frames: {}\n", count, arguments.out.string());
}

}  // namespace

void add_render(CLI::App& program) {
  CLI::App& verb = add_verb(program, "render", "Make labelled synthetic frames from a manifest",
                            "knuckle render --manifest manifests/demo.toml --out demo.h5");
  auto arguments = std::make_shared<RenderArguments>();
  verb.add_option("--manifest", arguments->manifest, "What to render (manifests/)")->required();
  verb.add_option("--out", arguments->out, "File (h5) or folder (folder, icg) to write")->required();
  verb.add_option("--format", arguments->format, "h5, folder or icg")->capture_default_str();
  verb.add_option("--first", arguments->first, "First frame")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb.add_option("--count", arguments->count, "Number of frames; 0: all from the first on")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb.callback([arguments] { run_render(*arguments); });
}

}  // namespace knuckle::cli
