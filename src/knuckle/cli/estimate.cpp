// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/pipeline/estimate_files.h"
#include "knuckle/pipeline/run_warnings.h"
#include "knuckle/prepare/inputs.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/prepare/source_fingerprint.h"
#include "knuckle/storage/content_hash.h"
#include "knuckle/storage/file_io.h"
#include "knuckle/track/track_each.h"

namespace knuckle::cli {
namespace {

struct EstimateArguments {
  std::string source;
  std::filesystem::path pipeline = resource_path("pipelines/default.toml");
  std::filesystem::path out;
  std::filesystem::path records;
  std::filesystem::path json;
  std::filesystem::path landmarks;
  std::string init = "nearest";
  bool resume = false;
  bool keep_going = false;
};

/// What the results depend on, apart from what the run itself knows.
RunIdentity identity_of(const EstimateArguments& arguments, const Pipeline& pipeline,
                        const EstimateFiles& files) {
  const std::vector<std::filesystem::path> written = all_files_of(files, pipeline.hand().max_hands);
  return {{"version of knuckle", KNUCKLE_VERSION},
          {"source (its settings or files)", source_fingerprint(arguments.source, written)},
          {"pipeline (its options)", text_hash(pipeline.resolved_options())},
          {"landmarks",
           arguments.landmarks.empty() ? "the model's" : content_hash(definition_file(arguments.landmarks))},
          {"model", text_hash(Inputs().add_models(arguments.pipeline).text())}};
}

EstimateFiles files_of(const EstimateArguments& arguments, const Pipeline& pipeline) {
  using enum GrowingFiles::Begin;
  EstimateFiles files;
  files.poses = arguments.out;
  files.records = arguments.records;
  files.summary = arguments.json;
  files.source_name = arguments.source;
  files.start = start_from_name(arguments.init);
  files.begin = arguments.resume ? where_it_stopped : anew;
  files.identity = identity_of(arguments, pipeline, files);
  if (pipeline.tracker()) files.run = track_each;
  files.finish = [&] { write_resolved_options(arguments.out, pipeline.resolved_options()); };
  return files;
}

/// A run that did not end is replaced by one without --resume, as a file of the same name would be.
void warn_of_replacement(const EstimateArguments& arguments) {
  const std::filesystem::path partial = partial_path(arguments.out);
  if (arguments.resume || !std::filesystem::exists(partial)) return;
  fmt::print(
      stderr,
      "warning: {}: is left from a run that did not end, and is replaced; --resume would go on with it\n",
      printable(partial.string()));
}

/// Frames that could not be read: an error, or a warning where the user said so.
void tell_of_faults(const EstimateArguments& arguments, const RunCounts& counts) {
  if (counts.unreadable == 0) return;
  const std::string faults =
      fmt::format("{} of {} frames could not be read and have no hand in {}; the first is frame {}: {}",
                  counts.unreadable, counts.frames, arguments.out.string(), counts.first_fault, counts.fault);
  if (!arguments.keep_going) throw Error(faults);
  fmt::print(stderr, "warning: {}\n", printable(faults));
}

void run_estimate(const EstimateArguments& arguments) {
  for (const auto& path : {arguments.out, arguments.records, arguments.json}) {
    if (!path.empty()) check_writable(path);
  }
  const auto source = open_source(arguments.source);
  Pipeline pipeline = Pipeline::load(arguments.pipeline);
  if (!arguments.landmarks.empty())
    pipeline.use_landmarks(LandmarkDefinition::load(definition_file(arguments.landmarks)));
  warn_of_replacement(arguments);
  RunWarnings warnings;
  EstimateFiles files = files_of(arguments, pipeline);
  files.warnings = &warnings;
  const auto [counts, durations] = estimate_to_files(*source, pipeline, files);
  const std::optional<double> median_ms = durations.total.median_ms();
  fmt::print("{} frames, hand found in {}{}: {}\n", counts.frames, counts.found,
             median_ms ? fmt::format(", median {:.2f} ms per frame", *median_ms) : "",
             arguments.out.string());
  for (const std::string& message : warnings.messages())
    fmt::print(stderr, "warning: {}\n", printable(message));
  tell_of_faults(arguments, counts);
}

}  // namespace

void add_estimate(CLI::App& program) {
  CLI::App& verb = add_verb(program, "estimate", "Estimate the pose of the hand in every frame of a source",
                            "knuckle estimate --source synthetic:manifests/demo.toml --out poses.txt");
  auto arguments = std::make_shared<EstimateArguments>();
  add_source_option(verb, arguments->source);
  verb.add_option("--pipeline", arguments->pipeline, "Pipeline file (pipelines/)")
      ->type_name("FILE")
      ->capture_default_str();
  verb.add_option("--out", arguments->out,
                  "Poses file: one line per frame, J x `u v d`; nan where there is no hand")
      ->type_name("FILE")
      ->required();
  verb.add_option(
          "--records", arguments->records,
          "Frame records: one line of JSON per frame, with joints in mm and px, confidences and status")
      ->type_name("FILE");
  verb.add_option("--json", arguments->json,
                  "Summary as JSON: confidences, frames without a hand, times of each stage")
      ->type_name("FILE");
  add_landmarks_option(verb, arguments->landmarks, "Poses have the landmarks of this definition");
  add_init_option(verb, arguments->init);
  verb.add_flag("--resume", arguments->resume,
                "Go on where a run with the same source and options was stopped, from its .partial files");
  verb.add_flag("--keep-going", arguments->keep_going,
                "Frames that cannot be read are a warning, not an error at the end");
  verb.callback([arguments] { run_estimate(*arguments); });
}

}  // namespace knuckle::cli
