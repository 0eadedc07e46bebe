// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "knuckle/cli/verb.h"
#include "knuckle/core/error.h"
#include "knuckle/core/own_convention.h"
#include "knuckle/core/text.h"
#include "knuckle/data/boxes_file.h"
#include "knuckle/data/readers/image_io.h"
#include "knuckle/eval/metrics/evaluation.h"
#include "knuckle/eval/metrics/followed_hands.h"
#include "knuckle/eval/metrics/score_files.h"
#include "knuckle/eval/pictures/angle_figures.h"
#include "knuckle/eval/pictures/film_strip.h"
#include "knuckle/eval/pictures/gallery.h"
#include "knuckle/eval/report/report.h"
#include "knuckle/hand/landmark_definition.h"
#include "knuckle/prepare/open_source.h"
#include "knuckle/storage/file_io.h"

namespace knuckle::cli {
namespace {

struct EvaluateArguments {
  std::string truth;
  std::vector<std::string> predictions;
  std::vector<std::string> boxes;
  std::vector<std::string> records;
  std::string convention;
  std::string camera;
  std::filesystem::path out;
  std::filesystem::path json;
  std::filesystem::path landmarks;
  std::filesystem::path strip;
  std::string format = "uvd";
  std::string axes = "x,y,z";
  std::string unit = "mm";
  bool common = false;
  GalleryOptions gallery;

  void visit(OptionVisitor& visitor) {
    visitor.text("truth", truth);
    visitor.texts("predictions", predictions, {});
    visitor.texts("boxes", boxes, {});
    visitor.texts("records", records, {});
    visitor.text("convention", convention);
    visitor.text("camera", camera);
    std::string definition = landmarks.string();
    visitor.text("landmarks", definition);
    visitor.text("format", format);
    visitor.text("axes", axes);
    visitor.text("unit", unit);
    visitor.flag("common", common);
  }
};

/// The truth, and the frames to show where it comes from a source.
struct OpenedTruth {
  Truth truth;
  std::unique_ptr<FrameSource> source;  ///< null where the truth is a file
  PixelOrigin pixel_origin = PixelOrigin::centre;
};

std::optional<Convention> chosen_convention(const EvaluateArguments& arguments) {
  if (arguments.convention.empty()) return std::nullopt;
  return convention_from_option(arguments.convention);
}

OpenedTruth read_truth_file(const EvaluateArguments& arguments) {
  if (arguments.camera.empty()) {
    fail("{}: truth from a file needs its camera: --camera fx,fy,cx,cy", arguments.truth);
  }
  const Camera camera = camera_from_text(arguments.camera);
  return {truth_from_file(arguments.truth, chosen_convention(arguments), camera), nullptr,
          PixelOrigin::centre};
}

PoseCoordinates chosen_coordinates(const EvaluateArguments& arguments) {
  PoseCoordinates chosen{coordinate_kind_from_text(arguments.format), axes_from_text(arguments.axes),
                         unit_from_text(arguments.unit)};
  if (chosen.kind == PoseCoordinates::Kind::uvd && chosen.axes != PoseCoordinates().axes)
    fail("--axes: tells of x y z; give --format xyz too");
  return chosen;
}

std::vector<NamedPath> prediction_files(const EvaluateArguments& arguments) {
  std::vector<NamedPath> files;
  for (const std::string& text : arguments.predictions) files.push_back(named_path_from_text(text));
  return files;
}

std::vector<Predictions> read_predictions(const EvaluateArguments& arguments, const Truth& truth,
                                          PixelOrigin origin) {
  std::vector<std::string> remarks;
  std::vector<Predictions> predictions =
      predictions_from_files(prediction_files(arguments), truth,
                             {chosen_convention(arguments), chosen_coordinates(arguments), origin}, remarks);
  for (const std::string& remark : remarks) fmt::print(stderr, "warning: {}\n", printable(remark));
  return predictions;
}

void print_scores(const std::vector<MethodScore>& methods) {
  fmt::print("{:<24} {:>7} {:>8} {:>9} {:>11} {:>9} {:>9}\n", "method", "frames", "missing", "mean mm",
             "median mm", "mean px", "AUC 0-50");
  for (const MethodScore& method : methods) {
    fmt::print("{:<24} {:>7} {:>8} {:>9.3f} {:>11.3f} {:>9.3f} {:>9.4f}\n", printable(method.name),
               method.frames, method.missing, method.mean_3d_mm, method.median_3d_mm, method.mean_2d_px,
               method.auc_pck_0_50);
  }
}

void print_differences(const Evaluation& evaluation) {
  for (const MethodDifference& found : evaluation.differences) {
    if (!std::isfinite(found.mean_mm)) continue;
    fmt::print("{} less {}: {:+.3f} mm ({:+.3f} to {:+.3f}, p {:.3f}, {} frames)\n",
               evaluation.methods[found.first].name, evaluation.methods[found.second].name, found.mean_mm,
               found.low_mm, found.high_mm, found.p_value, found.frames);
  }
}

void print_scores(const Evaluation& evaluation) {
  print_scores(evaluation.methods);
  if (!evaluation.in_common.empty()) {
    fmt::print("\nIn the {} landmarks that all share:\n", evaluation.in_common.front().joints.size());
    print_scores(evaluation.in_common);
  }
  print_differences(evaluation);
}

/// Boxes count pixels, whose numbers do not depend on where a source's coordinates start.
std::vector<SegmentationScore> score_box_files(const EvaluateArguments& arguments, const Truth& truth) {
  std::vector<SegmentationScore> scores;
  for (const std::string& text : arguments.boxes) {
    const NamedPath file = named_path_from_text(text);
    scores.push_back(score_boxes(file.name, read_boxes_file(file.path), truth.sequence.poses));
  }
  return scores;
}

void print_scores(const std::vector<SegmentationScore>& scores) {
  fmt::print("{:<24} {:>7} {:>8} {:>9} {:>11} {:>9}\n", "boxes", "frames", "missing", "mean r", "median r",
             "r > 0.5");
  for (const SegmentationScore& score : scores) {
    constexpr std::size_t kHalf = 50;  // the curve has a value per hundredth
    fmt::print("{:<24} {:>7} {:>8} {:>9.4f} {:>11.4f} {:>9.4f}\n", printable(score.name), score.frames,
               score.missing, score.mean_iou, score.median_iou, score.fraction_above.at(kHalf));
  }
}

std::vector<NamedRecords> read_records(const EvaluateArguments& arguments, const FrameSource* source) {
  std::vector<NamedRecords> records;
  if (arguments.records.empty()) return records;
  if (source == nullptr)
    fail("--records: hands are scored against a source KIND:PATH, which knows all hands");
  for (const std::string& text : arguments.records) {
    const NamedPath file = named_path_from_text(text);
    records.push_back({file.name, records_from_file(file.path, source->size())});
  }
  return records;
}

/// Frame records against all hands of the source.
std::vector<FollowedScore> score_records(const std::vector<NamedRecords>& records,
                                         const FrameSource* source) {
  std::vector<FollowedScore> scores;
  if (records.empty()) return scores;
  const std::vector<TrueHands> truth = true_hands(*source);
  for (const NamedRecords& method : records)
    scores.push_back(followed_score(method.name, *source->convention(), truth, method.frames));
  return scores;
}

void print_hidden(const FollowedScore& score) {
  const OcclusionScore& visible = score.occlusion.front();
  const OcclusionScore hidden = hidden_of(score.occlusion);
  if (visible.joints + hidden.joints == 0) return;
  fmt::print("{}: {} visible landmarks {:.1f} mm off on average, {} hidden ones {:.1f} mm\n",
             printable(score.name), visible.joints, visible.mean_3d_mm, hidden.joints, hidden.mean_3d_mm);
}

void print_scores(const std::vector<FollowedScore>& scores) {
  fmt::print("{:<24} {:>7} {:>7} {:>10} {:>9} {:>9} {:>6} {:>13} {:>9}\n", "records", "hands", "found",
             "right side", "invented", "switches", "losses", "longest loss", "mean mm");
  for (const FollowedScore& score : scores) {
    fmt::print("{:<24} {:>7} {:>7} {:>10} {:>9} {:>9} {:>6} {:>13} {:>9.3f}\n", printable(score.name),
               score.hands, score.found, score.right_side, score.invented, score.switches, score.losses,
               score.longest_loss, score.mean_3d_mm);
  }
  for (const FollowedScore& score : scores) print_hidden(score);
  for (const FollowedScore& score : scores) {
    if (score.reliability.joints == 0) continue;
    fmt::print("{}: confidences differ from the share of joints within {:.0f} mm by {:.1f} % on average\n",
               printable(score.name), kReliableMm, 100.0 * score.reliability.error);
  }
}

void write_options(const EvaluateArguments& arguments, const std::filesystem::path& output) {
  write_resolved_options(output,
                         options_as_toml(arguments) + "\n[gallery]\n" + options_as_toml(arguments.gallery));
}

void write_out(const EvaluateArguments& arguments, const Report& report) {
  fmt::print("report: {}\n", printable(write_report(report, arguments.out).string()));
  write_options(arguments, arguments.out);
}

/// What is asked for in pictures alone.
void write_strip(const EvaluateArguments& arguments, const GalleryInput& input) {
  if (!arguments.strip.empty()) write_png(arguments.strip, film_strip(input));
}

/// A source without truth: nothing can be scored, but the poses can be looked at.
void show_unlabelled(const EvaluateArguments& arguments, const FrameSource& source) {
  const bool wants_pictures = !arguments.out.empty() || !arguments.strip.empty();
  if (!wants_pictures || !arguments.json.empty() || !arguments.boxes.empty()) {
    fail("{}: the source has no truth to score against; --out and --strip alone make pictures",
         arguments.truth);
  }
  if (chosen_coordinates(arguments).kind != PoseCoordinates::Kind::uvd)
    fail("--format: without truth poses are looked at in the image, in u v d");
  const std::vector<Predictions> predictions = predictions_from_files(
      prediction_files(arguments), chosen_convention(arguments), source.pixel_origin());
  for (const Predictions& method : predictions) {
    if (static_cast<std::int64_t>(method.sequence.poses.size()) != source.size()) {
      fail("{}: holds {} poses, the source {} has {} frames", method.sequence.origin,
           method.sequence.poses.size(), arguments.truth, source.size());
    }
  }
  const std::vector<NamedRecords> records = read_records(arguments, &source);
  const GalleryInput input{&source, nullptr, nullptr, predictions, records};
  write_strip(arguments, input);
  if (arguments.out.empty()) return;
  Report report;
  report.title = "Hand poses";
  report.facts = {{"source", arguments.truth}, {"truth", "none: nothing is scored"}};
  report.angles = angle_figures(records);
  report.gallery = make_gallery(input, arguments.gallery);
  write_out(arguments, report);
}

/// Says where the truth's landmarks lie elsewhere than those of predictions that could be moved there.
void tell_of_definition(const Truth& truth, const std::vector<Predictions>& predictions) {
  const Convention& labelled = truth.sequence.convention;
  if (map_convention(labelled, superset_convention()).missing.empty() || !shipped_definition(labelled))
    return;
  const bool can_be_moved = std::ranges::any_of(predictions, [](const Predictions& method) {
    return map_convention(method.sequence.convention, superset_convention()).missing.empty();
  });
  if (!can_be_moved) return;
  fmt::print("{} has its landmarks elsewhere on the hand: --landmarks {} moves predictions there\n",
             labelled.name, labelled.name);
}

void score_labelled(const EvaluateArguments& arguments, OpenedTruth& opened) {
  std::optional<LandmarkDefinition> definition;
  if (!arguments.landmarks.empty())
    definition = LandmarkDefinition::load(definition_file(arguments.landmarks));
  std::vector<Predictions> predictions = read_predictions(arguments, opened.truth, opened.pixel_origin);
  if (definition) move_landmarks(*definition, opened.truth, predictions);
  Report report;
  if (!predictions.empty()) {
    report.evaluation = evaluate(opened.truth, predictions, arguments.common);
    print_scores(*report.evaluation);
    if (!definition) tell_of_definition(opened.truth, predictions);
  }
  report.segmentation = score_box_files(arguments, opened.truth);
  if (!report.segmentation.empty()) print_scores(report.segmentation);
  const std::vector<NamedRecords> records = read_records(arguments, opened.source.get());
  report.followed = score_records(records, opened.source.get());
  if (!report.followed.empty()) print_scores(report.followed);
  if (!arguments.json.empty()) {
    write_text_file(arguments.json, to_json(report.evaluation, report.segmentation, report.followed));
    write_options(arguments, arguments.json);
  }
  const bool has_pictures = report.evaluation || !records.empty();
  const GalleryInput input{opened.source.get(), &opened.truth,
                           report.evaluation ? &*report.evaluation : nullptr, predictions, records};
  if (has_pictures) write_strip(arguments, input);
  if (arguments.out.empty()) return;
  report.angles = angle_figures(records);
  if (has_pictures) report.gallery = make_gallery(input, arguments.gallery);
  write_out(arguments, report);
}

void run_evaluate(const EvaluateArguments& arguments) {
  if (arguments.predictions.empty() && arguments.boxes.empty() && arguments.records.empty()) {
    fail(
        "evaluate: nothing to score: give --predictions NAME=PATH, --boxes NAME=PATH or --records NAME=PATH");
  }
  if (arguments.predictions.empty() && arguments.records.empty() && !arguments.strip.empty())
    fail("evaluate: --strip shows estimates: give --predictions NAME=PATH or --records NAME=PATH");
  if (!names_a_source(arguments.truth)) {
    OpenedTruth opened = read_truth_file(arguments);
    return score_labelled(arguments, opened);
  }
  auto source = open_source(arguments.truth);
  if (!source->convention()) return show_unlabelled(arguments, *source);
  Truth truth = truth_from_source(*source, arguments.truth);
  const PixelOrigin origin = source->pixel_origin();
  OpenedTruth opened{std::move(truth), std::move(source), origin};
  score_labelled(arguments, opened);
}

}  // namespace

void add_evaluate(CLI::App& program) {
  CLI::App& verb = add_verb(
      program, "evaluate", "Score predicted poses against truth",
      "knuckle estimate --source synthetic:manifests/demo.toml --out poses.txt\n"
      "  knuckle evaluate --truth synthetic:manifests/demo.toml --predictions mine=poses.txt --out report");
  auto arguments = std::make_shared<EvaluateArguments>();
  verb.add_option("--truth", arguments->truth,
                  "A source KIND:PATH, or a file of `u v d` lines (then with --camera)")
      ->type_name("SOURCE")
      ->required();
  verb.add_option("--predictions", arguments->predictions, "Poses files, each with a name for the report")
      ->type_name("NAME=FILE");
  verb.add_option("--boxes", arguments->boxes,
                  "What `segment` wrote, to be scored against the box of the true joints")
      ->type_name("NAME=FILE");
  verb.add_option(
          "--records", arguments->records,
          "What `estimate --records` or `live --records` wrote, to be scored against all hands: which "
          "were found, with which side, under which id. Pictures show the surfaces that were fitted")
      ->type_name("NAME=FILE");
  verb.add_option("--convention", arguments->convention,
                  "Landmarks of files that do not name theirs: a name that `knuckle info` lists, or a file "
                  "of your own (NAME.toml)")
      ->type_name("NAME");
  add_landmarks_option(
      verb, arguments->landmarks,
      "All predictions are moved to the landmarks of this definition before they are scored");
  verb.add_option("--camera", arguments->camera, "Camera of a truth file [px]; a negative fy: y points up")
      ->type_name("FX,FY,CX,CY");
  verb.add_option("--format", arguments->format,
                  "Numbers of a joint in predictions: uvd, or xyz in camera coordinates")
      ->type_name("FORMAT")
      ->capture_default_str();
  verb.add_option(
          "--axes", arguments->axes,
          "Where x y z point, told in x (right), y (down) and z (forward): x,-y,-z as OpenGL has them")
      ->type_name("AXES")
      ->capture_default_str();
  verb.add_option("--unit", arguments->unit, "Unit of x y z, or of d: mm, cm or m")
      ->type_name("UNIT")
      ->capture_default_str();
  verb.add_flag("--common", arguments->common,
                "Also score the methods in the landmarks that all of them share");
  verb.add_option("--out", arguments->out, "Folder for an HTML report with figures")->type_name("FOLDER");
  verb.add_option("--json", arguments->json, "The scores as JSON")->type_name("FILE");
  verb.add_option(
          "--strip", arguments->strip,
          "A picture of all frames (at most 1000), each with its estimates, errors and fitted surfaces")
      ->type_name("FILE.png");
  verb.add_option("--gallery", arguments->gallery.even_frames,
                  "Frames that the report shows, spread over the sequence")
      ->check(CLI::Range(0, 1000).description(""))
      ->type_name("N")
      ->capture_default_str();
  verb.callback([arguments] { run_evaluate(*arguments); });
}

}  // namespace knuckle::cli
