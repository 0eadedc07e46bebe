// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/progress.h"
#include "knuckle/core/resources.h"
#include "knuckle/core/text.h"
#include "knuckle/data/defined_pose.h"
#include "knuckle/data/truth.h"
#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/hand/landmark_fit.h"
#include "knuckle/pipeline/estimate_each.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

struct LandmarksArguments {
  std::string source;
  std::filesystem::path pipeline = resource_path("pipelines/default.toml");
  std::filesystem::path out;
};

/// What a pipeline estimates in all frames with labels, started at the truth, beside these labels.
std::vector<LabelledPoints> labelled_points(const FrameSource& source, const Pipeline& pipeline,
                                            const Truth& truth) {
  std::vector<LabelledPoints> frames;
  Progress progress("estimate", "frames", source.size());
  estimate_each(source, pipeline, {.start = Start::truth}, [&](const FrameResult& result) {
    if (!result.fault.empty()) throw Error(result.fault);
    progress.advance();
    const HandPose& labels = truth.sequence.poses[static_cast<std::size_t>(result.index)];
    if (result.estimate.hands.empty() || labels.is_missing()) return;
    const HandEstimate& hand = result.estimate.hands.front();
    const Projection projection(result.camera);
    frames.push_back(
        {superset_points(hand.pose, projection), hand.side, points_in_camera(labels, projection)});
  });
  return frames;
}

void print_fit(const LandmarkFit& fit) {
  fmt::print("{:<16} {:>7} {:>10} {:>9} {:>16}   offset along, aside, backwards of a straight finger\n",
             "landmark", "frames", "before mm", "after mm", "cross-validated");
  const auto print_score = [](std::string_view name, const LandmarkFitScore& score) {
    fmt::print("{:<16} {:>7} {:>10.2f} {:>9.2f} {:>16.2f}", name, score.frames, score.before_mm,
               score.after_mm, score.validated_mm);
  };
  for (std::size_t i = 0; i < fit.landmarks.size(); ++i) {
    const Eigen::Vector3d& offset = fit.definition.landmarks[i].offset;
    print_score(name_of(fit.definition.convention.landmarks[i]), fit.landmarks[i]);
    fmt::print("   {:+.3f} {:+.3f} {:+.3f}\n", offset.x(), offset.y(), offset.z());
  }
  print_score("all", fit.all);
  fmt::print("\n");
}

std::string head_of(const LandmarksArguments& arguments, const LandmarkFit& fit) {
  return fmt::format(
      "# Where the landmarks of {} lie on the hand, fitted by `knuckle landmarks` to {}.\n"
      "# Mean distance {:.2f} mm before, {:.2f} mm after, {:.2f} mm cross-validated. What the estimates "
      "always do wrong\n"
      "# is taken in as well. Offsets are in palm lengths (wrist to middle MCP).\n",
      fit.definition.convention.name, printable(arguments.source), fit.all.before_mm, fit.all.after_mm,
      fit.all.validated_mm);
}

void run_landmarks(const LandmarksArguments& arguments) {
  check_writable(arguments.out);
  const auto source = open_source(arguments.source);
  const Truth truth = truth_from_source(*source, arguments.source);
  const Pipeline pipeline = Pipeline::load(arguments.pipeline);
  require_all_landmarks(pipeline.convention(), arguments.pipeline.string());
  const std::vector<LabelledPoints> frames = labelled_points(*source, pipeline, truth);
  const LandmarkFit fit = [&] {
    try {
      const Convention& convention = truth.sequence.convention;
      return fit_landmarks(shipped_definition(convention).value_or(LandmarkDefinition::plain(convention)),
                           frames);
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", arguments.source, error.what()));
    }
  }();
  print_fit(fit);
  fmt::print("what the estimates always do wrong is taken in as well\n");
  write_text_file(arguments.out, head_of(arguments, fit) + fit.definition.as_toml());
  fmt::print("definition: {}\n", printable(arguments.out.string()));
}

}  // namespace

void add_landmarks(CLI::App& program) {
  CLI::App& verb =
      add_verb(program, "landmarks", "Fit where a data set's own landmarks lie on the hand",
               "knuckle landmarks --source synthetic:manifests/demo.toml --out landmarks.toml\n"
               "  knuckle estimate --source synthetic:manifests/demo.toml --landmarks landmarks.toml "
               "--out poses.txt");
  auto arguments = std::make_shared<LandmarksArguments>();
  add_source_option(verb, arguments->source);
  verb.add_option("--pipeline", arguments->pipeline,
                  "Pipeline file whose estimates, started at the truth, are compared with the labels")
      ->type_name("FILE")
      ->capture_default_str();
  verb.add_option("--out", arguments->out, "Definition to write (TOML)")->type_name("FILE")->required();
  verb.callback([arguments] { run_landmarks(*arguments); });
}

}  // namespace knuckle::cli
