// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/data/poses_file.h"
#include "knuckle/eval/pictures/gallery.h"
#include "knuckle/eval/report/report.h"
#include "knuckle/pipeline/estimate_all.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

struct DemoArguments {
  std::filesystem::path out = "demo";
};

/// Frames a second that one core manages, from the median time of a frame.
double frames_per_second(std::span<const FrameEstimate> frames) {
  return 1000.0 / median_ms(frames);
}

Report report_of(const FrameSource& source, const std::string& name, std::span<const FrameEstimate> frames,
                 const Convention& convention) {
  const Truth truth = truth_from_source(source, name);
  const std::vector<Predictions> predictions = {
      {"default pipeline", {name, convention, poses_of(frames, convention)}}};
  Report report;
  report.title = "Knuckle demo";
  report.facts = {{"source", name},
                  {"speed", fmt::format("{:.0f} frames/s on one core", frames_per_second(frames))}};
  report.evaluation = evaluate(truth, predictions);
  report.gallery = make_gallery({&source, &truth, &*report.evaluation, predictions});
  return report;
}

void run_demo(const DemoArguments& arguments) {
  make_folder(arguments.out);
  const std::string name = "synthetic:" + resource_path("manifests/demo.toml").string();
  const auto pipeline_path = resource_path("pipelines/default.toml");
  const auto source = open_source(name);
  const Pipeline pipeline = Pipeline::load(pipeline_path);
  const std::vector<FrameEstimate> frames = estimate_all(*source, pipeline, Start::nearest, name);
  const Report report = report_of(*source, "synthetic:manifests/demo.toml", frames, pipeline.convention());
  const auto page = write_report(report, arguments.out);
  write_poses_file(arguments.out / "poses.txt", pipeline.convention(),
                   poses_of(frames, pipeline.convention()));
  write_resolved_options(arguments.out, pipeline.resolved_options());
  const MethodScore& score = report.evaluation->methods.front();
  fmt::print("{} frames at {:.0f} frames/s on one core, mean 3D error {:.1f} mm\n", frames.size(),
             frames_per_second(frames), score.mean_3d_mm);
  fmt::print("report: {}\n", printable(std::filesystem::absolute(page).string()));
}

}  // namespace

void add_demo(CLI::App& program) {
  CLI::App& verb = add_verb(program, "demo", "The shipped pipeline on a short recording, and its report",
                            "knuckle demo --out demo");
  auto arguments = std::make_shared<DemoArguments>();
  verb.add_option("--out", arguments->out, "Folder for the report")
      ->type_name("FOLDER")
      ->capture_default_str();
  verb.callback([arguments] { run_demo(*arguments); });
}

}  // namespace knuckle::cli
