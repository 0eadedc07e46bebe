// SPDX-License-Identifier: Apache-2.0
#include "knuckle/eval/metrics/evaluation.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "knuckle/core/own_convention.h"
#include "knuckle/core/parallel.h"
#include "knuckle/core/testing.h"
#include "knuckle/core/text_file.h"
#include "knuckle/data/truth.h"
#include "knuckle/eval/metrics/eval_fixtures.h"
#include "knuckle/eval/metrics/score_files.h"
#include "knuckle/storage/file_io.h"

namespace knuckle {
namespace {

using knuckle::testing::error_of;
using knuckle::testing::TemporaryFolder;
using testing::example_predictions;
using testing::example_truth;
using testing::FakeSource;
using ::testing::HasSubstr;

TEST(CameraText, HoldsFocalLengthsAndPrincipalPoint) {
  const Camera camera = camera_from_text("588.03,-587.07,320,240");
  EXPECT_EQ(camera.fx, 588.03);
  EXPECT_EQ(camera.fy, -587.07);
  EXPECT_EQ(camera.cx, 320.0);
  EXPECT_EQ(camera.cy, 240.0);
  const Point3 point = Projection(camera).to_camera(ImagePoint{420.0, 140.0, 500.0});
  EXPECT_NEAR(point.x(), 100.0 * 500.0 / 588.03, 1e-9);
  EXPECT_NEAR(point.y(), 100.0 * 500.0 / 587.07, 1e-9);  // up is positive
}

TEST(CameraText, FaultsAreQuoted) {
  for (const std::string text : {"1,2,3", "1,2,3,4,5", "1,2,3,x", "0,1,2,3", "1,0,2,3", "nan,1,2,3",
                                 "inf,1,2,3", "1e-320,1,2,3", "1,1e10,2,3", "1,1,1e6,3", ""}) {
    EXPECT_THAT(error_of([&] { camera_from_text(text); }), HasSubstr("'" + text + "'"));
  }
}

TEST(NamedPath, IsCutAtTheFirstEqualsSign) {
  const NamedPath named = named_path_from_text("DeepPrior++=a=b.txt");
  EXPECT_EQ(named.name, "DeepPrior++");
  EXPECT_EQ(named.path, "a=b.txt");
  for (const std::string text : {"a", "=b", "a="}) {
    EXPECT_THAT(error_of([&] { named_path_from_text(text); }), HasSubstr("'" + text + "'"));
  }
}

TEST(Evaluate, RefusesNoMethodAndEqualNames) {
  const Truth truth = example_truth(4);
  EXPECT_THAT(error_of([&] { evaluate(truth, {}); }), HasSubstr("at least one"));
  const std::vector<Predictions> twice = {example_predictions(truth, "a", 1.0),
                                          example_predictions(truth, "a", 2.0)};
  EXPECT_THAT(error_of([&] { evaluate(truth, twice); }), HasSubstr("a: two methods"));
}

TEST(Evaluate, RefusesATruthWithTooFewCameras) {
  Truth truth = example_truth(4);
  const std::vector<Predictions> methods = {example_predictions(truth, "a", 1.0)};
  truth.projections.resize(2, truth.projections[0]);
  EXPECT_THAT(error_of([&] { evaluate(truth, methods); }),
              HasSubstr("expected one camera, or one for each of 4 frames, found 2"));
}

TEST(Evaluate, RefusesATruthThatSaysNothingOfWhatIsPredicted) {
  Truth truth = example_truth(3);
  const std::vector<Predictions> methods = {example_predictions(truth, "a", 1.0)};
  for (HandPose& pose : truth.sequence.poses) pose = HandPose::missing(pose.convention);
  EXPECT_THAT(error_of([&] { evaluate(truth, methods); }),
              HasSubstr("the truth holds no known joint that a predicts"));
  Predictions elsewhere = methods[0];
  elsewhere.sequence.convention = register_convention("eval_elsewhere", {Landmark::nyu_wrist_1});
  for (HandPose& pose : elsewhere.sequence.poses) pose = HandPose::missing(elsewhere.sequence.convention);
  EXPECT_THAT(error_of([&] { evaluate(truth, {elsewhere}); }),
              HasSubstr("its convention eval_elsewhere shares no landmark with the truth's, icg20"));
}

TEST(Evaluate, GivesTheSameForAnyNumberOfThreads) {
  const Truth truth = example_truth(50);
  const std::vector<Predictions> methods = {example_predictions(truth, "a", 1.0),
                                            example_predictions(truth, "b", 9.0)};
  set_thread_count(1);
  const std::string one = to_json(evaluate(truth, methods)) + curves_csv(evaluate(truth, methods));
  set_thread_count(4);
  const std::string four = to_json(evaluate(truth, methods)) + curves_csv(evaluate(truth, methods));
  set_thread_count(0);
  EXPECT_EQ(one, four);
}

TEST(Evaluate, ASignOfTheYAxisChangesNothing) {
  Truth truth = example_truth(10);
  const std::vector<Predictions> methods = {example_predictions(truth, "a", 3.0)};
  const double down = evaluate(truth, methods).methods[0].mean_3d_mm;
  Camera camera = truth.projections[0].camera();
  camera.fy = -camera.fy;
  truth.projections = {Projection(camera)};
  EXPECT_NEAR(evaluate(truth, methods).methods[0].mean_3d_mm, down, 1e-12);
}

TEST(Evaluate, ReadsTruthFromASource) {
  const Truth expected = example_truth(6);
  const FakeSource source(expected);
  const Truth truth = truth_from_source(source, "fake:source");
  EXPECT_EQ(truth.sequence.convention, expected.sequence.convention);
  EXPECT_EQ(truth.projections.size(), 1u);  // all frames have one camera
  const MethodScore score = evaluate(truth, {example_predictions(expected, "perfect", 0.0)}).methods[0];
  EXPECT_EQ(score.mean_3d_mm, 0.0);
  EXPECT_EQ(score.frames, 6);
}

/// A source whose frames have cameras of their own.
class ZoomingSource final : public FrameSource {
 public:
  std::int64_t size() const override { return 3; }
  Frame read(std::int64_t index) const override {
    Frame frame;
    const double focal = 100.0 * static_cast<double>(index + 1);
    frame.camera = {.width = 80, .height = 60, .fx = focal, .fy = focal, .cx = 39.5, .cy = 29.5};
    frame.truth = HandPose::missing(convention_from_name("nyu14"));
    frame.truth->joints[13] = {49.5, 29.5, 500.0};
    return frame;
  }
  std::optional<Convention> convention() const override { return convention_from_name("nyu14"); }
};

TEST(Evaluate, EachFrameIsScoredWithItsOwnCamera) {
  const Truth truth = truth_from_source(ZoomingSource(), "zoom");
  ASSERT_EQ(truth.projections.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(truth.projection(i).camera().fx, 100.0 * (i + 1));
  Predictions predictions{"x", {"x.txt", truth.sequence.convention, truth.sequence.poses}};
  for (HandPose& pose : predictions.sequence.poses) pose.joints[13].u += 6.0;
  const MethodScore score = evaluate(truth, {predictions}).methods[0];
  // 6 px are 30, 15 and 10 mm at 500 mm.
  ASSERT_EQ(score.frame_mean_3d_mm.size(), 3u);
  EXPECT_NEAR(score.frame_mean_3d_mm[0], 30.0, 1e-9);
  EXPECT_NEAR(score.frame_mean_3d_mm[1], 15.0, 1e-9);
  EXPECT_NEAR(score.frame_mean_3d_mm[2], 10.0, 1e-9);
  EXPECT_NEAR(score.mean_2d_px, 6.0, 1e-9);
}

TEST(Evaluate, ASourceWithoutTruthIsNamed) {
  const FakeSource source;
  EXPECT_THAT(error_of([&] { truth_from_source(source, "fake:source"); }),
              AllOf(HasSubstr("fake:source"), HasSubstr("no truth")));
}

TEST(Evaluate, FilesWithFewerLinesAreNamed) {
  const TemporaryFolder folder;
  const Truth truth = example_truth(5);
  const auto& poses = truth.sequence.poses;
  write_poses_file(folder / "truth.txt", truth.sequence.convention, poses);
  write_poses_file(folder / "short.txt", truth.sequence.convention, std::span(poses).first(3));
  const Truth read = truth_from_file(folder / "truth.txt", std::nullopt, camera_from_text("500,500,320,240"));
  const std::vector<NamedPath> files = {{"short", folder / "short.txt"}};
  EXPECT_THAT(
      error_of([&] { evaluate(read, predictions_from_files(files, std::nullopt)); }),
      AllOf(HasSubstr("short.txt"), HasSubstr("3 frames"), HasSubstr("truth.txt"), HasSubstr("has 5")));
}

/// The poses in another convention, whose own landmarks are not known.
Predictions in_convention(Predictions predictions, const char* name) {
  predictions.sequence.convention = convention_from_name(name);
  for (HandPose& pose : predictions.sequence.poses) pose = converted(pose, predictions.sequence.convention);
  return predictions;
}

TEST(EvaluateInCommon, ComparesWhatAllShare) {
  const Truth truth = example_truth(12);
  Predictions whole = example_predictions(truth, "whole", 2.0);
  const Predictions part = in_convention(example_predictions(truth, "part", 3.0), "nyu14");  // tips and palm
  const Convention& convention = truth.sequence.convention;
  for (HandPose& pose : whole.sequence.poses)
    pose.joints[convention.index_of(Landmark::ring_pip)].depth_mm += 500;
  const Evaluation evaluation = evaluate(truth, {whole, part}, true);
  EXPECT_FALSE(compare_the_same(evaluation.methods));
  ASSERT_EQ(evaluation.in_common.size(), 2u);
  EXPECT_TRUE(compare_the_same(evaluation.in_common));
  EXPECT_EQ(evaluation.in_common[0].joints.size(), 6u);
  EXPECT_GT(evaluation.methods[0].mean_3d_mm, 20.0);
  EXPECT_LT(evaluation.in_common[0].mean_3d_mm, 3.0);  // the joint that is far off is none of the six
  EXPECT_NEAR(evaluation.in_common[1].mean_3d_mm, evaluation.methods[1].mean_3d_mm, 1e-12);
  ASSERT_EQ(evaluation.differences.size(), 1u);
  EXPECT_NEAR(evaluation.differences[0].mean_mm,
              evaluation.in_common[0].mean_3d_mm - evaluation.in_common[1].mean_3d_mm, 1e-9);
  const nlohmann::json json = nlohmann::json::parse(to_json(evaluation));
  EXPECT_EQ(json["in_common"][1]["joints"].size(), 6u);
  EXPECT_EQ(json["differences"][0]["first"], "whole");
  EXPECT_EQ(json["differences"][0]["second"], "part");
}

TEST(EvaluateInCommon, AJointThatOnlyOneMissesDoesNotLoseTheFrame) {
  const Truth truth = example_truth(4);
  Predictions whole = example_predictions(truth, "whole", 1.0);
  whole.sequence.poses[2].joints[truth.sequence.convention.index_of(Landmark::ring_pip)] = {};
  const Predictions part = in_convention(example_predictions(truth, "part", 1.0), "nyu14");
  const Evaluation evaluation = evaluate(truth, {whole, part}, true);
  EXPECT_EQ(evaluation.methods[0].missing, 1);
  EXPECT_EQ(evaluation.in_common[0].missing, 0);
}

TEST(EvaluateInCommon, IsNotAskedForWhereAllShareAll) {
  const Truth truth = example_truth(6);
  const std::vector<Predictions> methods = {example_predictions(truth, "a", 1.0),
                                            example_predictions(truth, "b", 9.0)};
  const Evaluation evaluation = evaluate(truth, methods, true);
  EXPECT_TRUE(evaluation.in_common.empty());
  ASSERT_EQ(evaluation.differences.size(), 1u);
  EXPECT_LT(evaluation.differences[0].high_mm, 0.0);
  // Without the option methods in different landmarks have no difference that means something.
  EXPECT_TRUE(evaluate(truth, {methods[0], in_convention(methods[1], "nyu14")}).differences.empty());
}

TEST(EvaluateInCommon, NothingInCommonIsAnError) {
  const Truth truth = example_truth(3);
  Predictions icvl = example_predictions(truth, "a", 1.0);
  icvl.sequence.convention = convention_from_name("icvl16");  // shares the palm alone
  for (HandPose& pose : icvl.sequence.poses) pose = converted(pose, icvl.sequence.convention);
  Predictions msra = in_convention(example_predictions(truth, "b", 1.0), "msra21");  // has no palm
  EXPECT_THAT(error_of([&] { evaluate(truth, {icvl, msra}, true); }), HasSubstr("--common: no landmark"));
}

TEST(PredictionFiles, InSpaceAreSeenByTheCameraOfTheTruth) {
  const TemporaryFolder folder;
  const Truth truth = example_truth(5);
  std::string text = "# convention: icg20\n";
  for (const HandPose& pose : truth.sequence.poses) {
    for (const Point3& point : points_in_camera(pose, truth.projection(0)))
      text += std::to_string(point.x()) + " " + std::to_string(-point.y()) + " " +
              std::to_string(-point.z()) + " ";
    text += "\n";
  }
  write_text_file(folder / "space.txt", text);
  const std::vector<NamedPath> files = {{"mine", folder / "space.txt"}};
  PredictionFormat format;
  std::vector<std::string> remarks;
  const double as_pixels =
      evaluate(truth, predictions_from_files(files, truth, format, remarks)).methods[0].mean_3d_mm;
  EXPECT_GT(as_pixels, 100.0);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_THAT(remarks[0],
              AllOf(HasSubstr("space.txt: read so"), HasSubstr("with --format xyz --axes x,-y,-z more")));
  format.coordinates = {PoseCoordinates::Kind::xyz, axes_from_text("x,-y,-z")};
  remarks.clear();
  EXPECT_LT(evaluate(truth, predictions_from_files(files, truth, format, remarks)).methods[0].mean_3d_mm,
            1e-3);
  EXPECT_TRUE(remarks.empty());
}

TEST(ScoreFiles, JsonHasTheAgreedKeys) {
  const Truth truth = example_truth(8);
  Predictions nothing = example_predictions(truth, "nothing \"quoted\"", 1.0);
  for (HandPose& pose : nothing.sequence.poses) pose = HandPose::missing(pose.convention);
  const nlohmann::json json =
      nlohmann::json::parse(to_json(evaluate(truth, {example_predictions(truth, "x", 4.0), nothing})));
  EXPECT_EQ(json["convention"], "icg20");
  ASSERT_EQ(json["methods"].size(), 2u);
  const nlohmann::json& method = json["methods"][0];
  std::vector<std::string> keys;
  for (const auto& item : method.items()) keys.push_back(item.key());
  EXPECT_THAT(keys, ::testing::UnorderedElementsAre("name", "frames", "missing", "joints", "mean_3d_mm",
                                                    "median_3d_mm", "mean_2d_px", "per_joint_3d_mm",
                                                    "frames_all_joints_within", "auc_pck_0_50", "motion"));
  keys.clear();
  for (const auto& item : method["motion"].items()) keys.push_back(item.key());
  EXPECT_THAT(keys, ::testing::UnorderedElementsAre("frames", "acceleration_mm", "true_acceleration_mm",
                                                    "acceleration_error_mm", "lag_frames", "jitter_mm",
                                                    "worst_jitter_mm", "bone_deviation"));
  EXPECT_EQ(method["motion"]["frames"], 6);
  EXPECT_TRUE(json["methods"][1]["motion"]["acceleration_mm"].is_null());
  EXPECT_EQ(method["name"], "x");
  EXPECT_EQ(method["frames"], 8);
  EXPECT_EQ(method["joints"].size(), 20u);
  EXPECT_EQ(method["joints"][0], "palm");
  EXPECT_EQ(method["per_joint_3d_mm"].size(), 20u);
  EXPECT_TRUE(method["frames_all_joints_within"].contains("20"));
  EXPECT_TRUE(method["frames_all_joints_within"].contains("40"));
  EXPECT_EQ(json["methods"][1]["missing"], 8);
  EXPECT_TRUE(json["methods"][1]["mean_3d_mm"].is_null());
}

TEST(ScoreFiles, CsvQuotesNamesWithSeparators) {
  const Truth truth = example_truth(3);
  const Evaluation evaluation = evaluate(truth, {example_predictions(truth, "a,\"b\"", 2.0)});
  EXPECT_THAT(joints_csv(evaluation), HasSubstr("\n\"a,\"\"b\"\"\",palm,3,"));
  EXPECT_THAT(frames_csv(evaluation), HasSubstr("\n\"a,\"\"b\"\"\",2,"));
  const std::string curves = curves_csv(evaluation);
  EXPECT_EQ(std::ranges::count(curves, '\n'), 1 + 81);
  EXPECT_THAT(curves, HasSubstr(",80,1.000000,1.000000,1.000000\n"));
}

TEST(ScoreFiles, FramesWithoutPredictionHaveEmptyErrors) {
  const Truth truth = example_truth(2);
  Predictions half = example_predictions(truth, "half", 0.0);
  half.sequence.poses[1] = HandPose::missing(half.sequence.convention);
  EXPECT_EQ(frames_csv(evaluate(truth, {half})),
            "method,frame,mean_3d_mm,largest_3d_mm\nhalf,0,0.0000,0.0000\nhalf,1,,\n");
}

}  // namespace
}  // namespace knuckle
