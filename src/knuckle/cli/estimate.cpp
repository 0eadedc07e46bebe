// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/resources.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/pipeline/run.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

struct EstimateArguments {
  std::string source;
  std::filesystem::path pipeline = resource_path("pipelines/default.toml");
  std::filesystem::path out;
  std::filesystem::path json;
  std::string init = "nearest";
};

/// "poses.txt" for the best hand of a frame, "poses.hand2.txt" for the second, and so on.
std::filesystem::path path_of_hand(const std::filesystem::path& out, int hand) {
  if (hand == 0) return out;
  return out.parent_path() /
         fmt::format("{}.hand{}{}", out.stem().string(), hand + 1, out.extension().string());
}

void run_estimate(const EstimateArguments& arguments) {
  check_writable(arguments.out);
  if (!arguments.json.empty()) check_writable(arguments.json);
  const auto source = open_source(arguments.source);
  const Pipeline pipeline = Pipeline::load(arguments.pipeline);
  const std::vector<FrameEstimate> frames =
      estimate_all(*source, pipeline, start_from_name(arguments.init), arguments.source);
  for (int hand = 0; hand < pipeline.hand().max_hands; ++hand) {
    write_poses_file(path_of_hand(arguments.out, hand), pipeline.convention(),
                     poses_of(frames, pipeline.convention(), hand), source->pixel_origin());
  }
  if (!arguments.json.empty()) {
    write_text_file(arguments.json, summary_json(frames, arguments.source, pipeline.convention()));
  }
  write_resolved_options(arguments.out, pipeline.resolved_options());
  const auto found =
      std::ranges::count_if(frames, [](const FrameEstimate& frame) { return !frame.hands.empty(); });
  fmt::print("{} frames, hand found in {}, median {:.2f} ms a frame: {}\n", frames.size(), found,
             median_ms(frames), arguments.out.string());
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
                  "Poses file: a line a frame, J x `u v d`; nan where there is no hand")
      ->type_name("FILE")
      ->required();
  verb.add_option("--json", arguments->json,
                  "Summary as JSON: confidences, frames without a hand, times of each stage")
      ->type_name("FILE");
  add_init_option(verb, arguments->init);
  verb.callback([arguments] { run_estimate(*arguments); });
}

}  // namespace knuckle::cli
